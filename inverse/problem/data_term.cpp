#include "inverse/problem/data_term.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/numbers/median.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

/// Median of |e| of a standard normal number.
constexpr double normal_median = 0.6744897501960817;

double rho(double e, const DataTermOptions& o) {
  const double a = std::abs(e);
  switch (o.loss) {
    case Loss::huber:
      return a <= o.huber_threshold ? 0.5 * e * e
                                    : o.huber_threshold * (a - 0.5 * o.huber_threshold);
    case Loss::student:
      return 0.5 * (o.student_freedom + 1.0) * std::log1p(e * e / o.student_freedom);
    default:
      return 0.5 * e * e;
  }
}

/// ψ(e)/e.
double reweight(double e, const DataTermOptions& o) {
  switch (o.loss) {
    case Loss::huber:
      return std::abs(e) <= o.huber_threshold ? 1.0 : o.huber_threshold / std::abs(e);
    case Loss::student:
      return (o.student_freedom + 1.0) / (o.student_freedom + e * e);
    default:
      return 1.0;
  }
}

/// Replaces the sums over e² in `term` by those with problem.precision.
void weigh_shared_errors(DataTerm& term, const Problem& problem,
                         const std::vector<double>& prediction, std::size_t used) {
  std::vector<double> e(prediction.size());
  for (std::size_t i = 0; i < e.size(); ++i) {
    e[i] = term.root_weight[i] * (prediction[i] - problem.data[i]);
  }
  std::vector<double> weighed = e;
  problem.precision->apply(weighed);
  double squares = 0.0;
  for (std::size_t i = 0; i < e.size(); ++i) {
    squares += e[i] * weighed[i];
    term.by_prediction[i] = term.root_weight[i] * weighed[i];
  }
  term.value = 0.5 * squares;
  term.chi2_per_value = squares / static_cast<double>(std::max<std::size_t>(1, used));
}

}  // namespace

bool shares_errors(const Problem& problem, const DataTermOptions& options) {
  return problem.precision && options.loss == Loss::gaussian;
}

double robust_chi2(double median) {
  return std::pow(median / normal_median, 2);
}

DataTerm evaluate(const Problem& problem, const std::vector<double>& prediction,
                  const DataTermOptions& options) {
  check(prediction.size() == problem.data.size(), "the prediction does not fit the data");
  const std::size_t cells = problem.seen_shape().cells();
  DataTerm term;
  term.by_prediction.assign(prediction.size(), 0.0);
  term.root_weight.assign(prediction.size(), 0.0);
  const bool robust = options.loss != Loss::gaussian;
  struct Sums {
    double cost = 0.0;
    double squares = 0.0;  ///< Σ e²
    std::size_t used = 0;
    std::vector<double> magnitudes;  ///< |e|, under a robust loss
  };
  std::vector<Sums> patterns(static_cast<std::size_t>(problem.patterns));
  for_rows(problem.patterns, [&](int pattern) {
    const auto m = static_cast<std::size_t>(pattern);
    Sums& sums = patterns[m];
    for (std::size_t i = m * cells; i < (m + 1) * cells; ++i) {
      if (problem.weight[i] == 0.0) continue;
      const double residual = prediction[i] - problem.data[i];
      const double e = std::sqrt(problem.weight[i]) * residual;
      const double weight = problem.weight[i] * reweight(e, options);
      sums.cost += rho(e, options);
      sums.squares += e * e;
      ++sums.used;
      if (robust) sums.magnitudes.push_back(std::abs(e));
      term.by_prediction[i] = weight * residual;
      term.root_weight[i] = std::sqrt(weight);
    }
  });
  Sums all;
  for (const Sums& sums : patterns) {
    all.cost += sums.cost;
    all.squares += sums.squares;
    all.used += sums.used;
    all.magnitudes.insert(all.magnitudes.end(), sums.magnitudes.begin(), sums.magnitudes.end());
  }
  term.value = std::isfinite(all.cost) ? all.cost : std::numeric_limits<double>::infinity();
  // Before a part of a shared problem is found to have no data: the others wait for it.
  if (std::isfinite(term.value) && shares_errors(problem, options)) {
    weigh_shared_errors(term, problem, prediction, all.used);
    return term;
  }
  if (all.used == 0) return term;
  if (!robust) {
    term.chi2_per_value = all.squares / static_cast<double>(all.used);
  } else {
    term.chi2_per_value = robust_chi2(upper_median(std::move(all.magnitudes)));
  }
  return term;
}

}  // namespace kappamu::inverse
