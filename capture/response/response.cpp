// Weighted least squares for the inverse response; see response.h for the model.
#include "capture/response/response.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/numbers/median.h"

namespace kappamu::capture {
namespace {

// Scale of the toe in v = ln(1 + (z - black)/toe) + shoulder term, as a share of the code range:
// below it the curve is taken to be nearly straight, above it nearly a power law. Between 2 % and
// 10 % the recovered curves of the tests differ by less than 0.1 % (median over codes).
constexpr double toe_share = 0.05;
// The shoulder term, -shoulder_weight ln(1 - (z - black)/((1 + shoulder) range)), stretches v
// towards the largest code. A curve that flattens there bends ever faster; without the term the
// smoothness that suits the rest cut that bend, and the curve's end, which sets its common factor,
// was 0.5 to 1.1 % off (film_curve in the tests). More of it (0.2 to 0.5) lets the extrapolation
// from the last samples wander: 0.5 to 0.8 % on curves without such a bend. So it would with
// samples that end early: the shoulder is a few times the gap they leave.
constexpr double least_shoulder = 0.05;
constexpr double shoulder_over_gap = 3.0;
constexpr double shoulder_weight = 0.1;
// Error of ln exposure no averaging removes (shutter, block texture under the curve's bend).
constexpr double log_exposure_floor = 0.002;
// Samples whose mean is nearer to black than this many of their standard errors say too little, and
// the logarithm would bias them: at 20 the bias is 1/(2 * 20^2) = 0.13 %.
constexpr double least_signal_to_noise = 20.0;
constexpr double tukey_constant = 4.685;  // 95 % efficiency on normal errors, as Huber's
constexpr double huber_constant = 1.345;
constexpr int unknowns = 192;    // of s
constexpr int plain_rounds = 2;  // until the weights fit the slope of the curve
constexpr int huber_rounds = 4;
constexpr int tukey_rounds = 3;

struct Observation {
  int knot = 0;         // between knot and knot + 1
  double weight_1 = 0;  // share of knot + 1
  double base = 0;      // ln((z - black)/(top - black))
  double log_exposure = 0;
  double code = 0;
  double code_variance = 0;   // of the block's mean
  double total_variance = 0;  // the same with log_exposure_floor, as a variance of the code
  double robust = 1;          // 1 for an inlier, 0 for an outlier
  double weight = 0;          // of ln exposure in the least squares
};

// All observations of one scene block; its unknown ln irradiance is eliminated.
using Group = std::vector<Observation>;

class Curve {
 public:
  Curve(double black_level, int bit_depth, int knots, double highest_code)
      : black_(black_level),
        range_((1 << bit_depth) - 1 - black_level),
        toe_(toe_share * range_),
        end_(range_ + std::max(least_shoulder * range_,
                               shoulder_over_gap * (black_level + range_ - highest_code))),
        step_(place(range_) / (knots - 1)),
        s_(Eigen::VectorXd::Zero(knots)) {}

  int knots() const { return static_cast<int>(s_.size()); }
  Eigen::VectorXd& s() { return s_; }
  double range() const { return range_; }
  double black() const { return black_; }
  double slope_at_black() const { return std::exp(s_[0]) / range_; }

  // The place of a code above black among the knots.
  void locate(double code, Observation& observation) const {
    const double at = place(code - black_) / step_;
    observation.knot = std::clamp(static_cast<int>(at), 0, knots() - 2);
    observation.weight_1 = at - observation.knot;
    observation.base = std::log((code - black_) / range_);
  }
  double g(const Observation& at) const {
    return at.base + s_[at.knot] * (1.0 - at.weight_1) + s_[at.knot + 1] * at.weight_1;
  }
  // dg/dz
  double slope(const Observation& at) const {
    const double z = at.code - black_;
    const double dv = 1.0 / (toe_ + z) + shoulder_weight / (end_ - z);
    return 1.0 / (at.code - black_) + (s_[at.knot + 1] - s_[at.knot]) / step_ * dv;
  }
  double linear(double code) const {
    if (code <= black_) return slope_at_black() * (code - black_);
    Observation at;
    locate(code, at);
    return std::exp(g(at));
  }

 private:
  // v of a code above black.
  double place(double z) const {
    return std::log1p(z / toe_) - shoulder_weight * std::log1p(-z / end_);
  }

  double black_;
  double range_;
  double toe_;
  double end_;
  double step_;
  Eigen::VectorXd s_;
};

std::vector<Group> usable_groups(const std::vector<ResponseSample>& samples, const Curve& curve) {
  constexpr int block_pixels = sample_block_px * sample_block_px;
  std::vector<Group> groups;
  for (const ResponseSample& sample : samples) {
    Group group;
    for (std::size_t j = 0; j < sample.code.size(); ++j) {
      if (sample.valid[j] == 0) continue;
      Observation seen;
      seen.code = sample.code[j];
      seen.log_exposure = sample.log_exposure[j];
      // Noise of the mean; rounding averages out only as far as noise moves the codes about.
      constexpr double rounding_variance = 1.0 / 12.0;
      const double dither = std::min(1.0, sample.variance[j] / rounding_variance);
      seen.code_variance = sample.variance[j] / block_pixels +
                           rounding_variance * (1.0 - dither + dither / block_pixels);
      const double signal = seen.code - curve.black();
      if (signal < least_signal_to_noise * std::sqrt(seen.code_variance)) continue;
      curve.locate(seen.code, seen);
      group.push_back(seen);
    }
    if (group.size() >= 2) groups.push_back(std::move(group));
  }
  return groups;
}

// Residual of each observation against its group's weighted mean; calls visit(observation, r).
template <class Visit>
void for_each_residual(std::vector<Group>& groups, const Curve& curve, const Visit& visit) {
  for (Group& group : groups) {
    double sum = 0.0;
    double weights = 0.0;
    for (const Observation& seen : group) {
      sum += seen.weight * (curve.g(seen) - seen.log_exposure);
      weights += seen.weight;
    }
    const double mean = weights > 0.0 ? sum / weights : 0.0;
    for (Observation& seen : group) visit(seen, curve.g(seen) - seen.log_exposure - mean);
  }
}

// Slopes of a curve that is flat or falls somewhere are bounded away from zero.
double safe_slope(const Curve& curve, const Observation& seen) {
  return std::max(curve.slope(seen), 1e-3 / (seen.code - curve.black()));
}

void weigh_by_noise(std::vector<Group>& groups, const Curve& curve) {
  for (Group& group : groups) {
    for (Observation& seen : group) {
      const double slope = safe_slope(curve, seen);
      const double floor = log_exposure_floor / slope;
      seen.total_variance = seen.code_variance + floor * floor;
      seen.robust = 1.0;
      seen.weight = 1.0 / (slope * slope * seen.total_variance);
    }
  }
}

enum class Robust { huber, tukey };

// Weights the residuals down in units of their robust spread: by Huber's function, which has one
// minimum and so finds its way from a poor curve, or by Tukey's, which then drops outliers
// altogether. Returns the share cut off (Tukey) or bounded (Huber).
double weigh_down_outliers(std::vector<Group>& groups, const Curve& curve, Robust robust) {
  std::vector<double> sizes;
  for_each_residual(groups, curve, [&](Observation& seen, double residual) {
    sizes.push_back(std::abs(residual) * std::sqrt(seen.weight));
  });
  if (sizes.empty()) return 0.0;
  const double spread =
      std::max(upper_median(sizes) / 0.6745, 1.0);  // never below the noise itself
  const double cut = (robust == Robust::tukey ? tukey_constant : huber_constant) * spread;
  std::size_t beyond = 0;
  std::size_t at = 0;
  for (Group& group : groups) {
    for (Observation& seen : group) {
      const double u = sizes[at++] / cut;
      beyond += u >= 1.0 ? 1 : 0;
      if (robust == Robust::tukey) {
        seen.robust = u < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
      } else {
        seen.robust = 1.0 / std::max(u, 1.0);
      }
      seen.weight *= seen.robust;
    }
  }
  return static_cast<double>(beyond) / static_cast<double>(sizes.size());
}

// Normal equations of s after elimination of each group's ln irradiance:
// sum of w (phi·s + y)² over observations, phi and y centred within the group.
struct NormalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double freedom = 0.0;  // observations less groups
};

NormalEquations assemble(const std::vector<Group>& groups, int knots) {
  NormalEquations normal{Eigen::MatrixXd::Zero(knots, knots), Eigen::VectorXd::Zero(knots)};
  Eigen::VectorXd mean(knots);
  for (const Group& group : groups) {
    mean.setZero();
    double mean_y = 0.0;
    double weights = 0.0;
    int used = 0;
    for (const Observation& seen : group) {
      const double y = seen.base - seen.log_exposure;
      const std::array<double, 2> phi{1.0 - seen.weight_1, seen.weight_1};
      for (int a = 0; a < 2; ++a) {
        for (int b = 0; b < 2; ++b) {
          normal.matrix(seen.knot + a, seen.knot + b) += seen.weight * phi[a] * phi[b];
        }
        normal.right[seen.knot + a] -= seen.weight * phi[a] * y;
        mean[seen.knot + a] += seen.weight * phi[a];
      }
      mean_y += seen.weight * y;
      weights += seen.weight;
      used += seen.weight > 0.0 ? 1 : 0;
    }
    if (used == 0) continue;
    normal.freedom += used - 1;
    for (const Observation& left : group) {
      for (int a = 0; a < 2; ++a) {
        const int i = left.knot + a;
        if (mean[i] == 0.0) continue;
        const double scaled = mean[i] / weights;
        for (const Observation& other : group) {
          for (int b = 0; b < 2; ++b) {
            const double share = (b == 0 ? 1.0 - other.weight_1 : other.weight_1) * other.weight;
            normal.matrix(i, other.knot + b) -= scaled * share;
          }
        }
        normal.right[i] += scaled * mean_y;
        mean[i] = 0.0;  // each knot of the group once
      }
    }
  }
  return normal;
}

// Sum of squared third differences of s: parabolas in v, so also a power law that bends, are free.
Eigen::MatrixXd roughness(int knots) {
  Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(knots, knots);
  const Eigen::Vector4d difference(-1.0, 3.0, -3.0, 1.0);
  for (int k = 0; k + 3 < knots; ++k) {
    penalty.block<4, 4>(k, k) += difference * difference.transpose();
  }
  return penalty;
}

// Squared residuals in units of the codes' noise. Measured in codes, not in ln exposure: with equal
// ratios between exposures a staircase of that ratio fits every ln exposure and hides the noise on
// its flat steps, but it explains no code.
double code_misfit(std::vector<Group>& groups, const Curve& curve) {
  double sum = 0.0;
  for_each_residual(groups, curve, [&](const Observation& seen, double residual) {
    const double codes = residual / safe_slope(curve, seen);
    sum += seen.robust * codes * codes / seen.total_variance;
  });
  return sum;
}

// Solves for half decades of the smoothness weight and keeps the curve of the least generalised
// cross-validation score; returns its weight.
double solve(std::vector<Group>& groups, Curve& curve) {
  const int knots = curve.knots();
  const NormalEquations normal = assemble(groups, knots);
  Eigen::MatrixXd gauge = Eigen::MatrixXd::Zero(knots, knots);
  gauge(knots - 1, knots - 1) = normal.matrix.trace();  // s = 0 at the largest code
  const Eigen::MatrixXd penalty = roughness(knots);
  const double scale = normal.matrix.trace() / knots;
  double best_score = std::numeric_limits<double>::infinity();
  double best_weight = 0.0;
  Curve best = curve;
  for (int half_decade = -2; half_decade <= 16; ++half_decade) {
    const double weight = scale * std::pow(10.0, 0.5 * half_decade);
    const Eigen::LDLT<Eigen::MatrixXd> factored(normal.matrix + gauge + weight * penalty);
    curve.s() = factored.solve(normal.right);
    curve.s().array() -= curve.s()[knots - 1];
    const double freedom = normal.freedom - factored.solve(normal.matrix).trace();
    if (freedom <= 1.0) continue;
    const double score = code_misfit(groups, curve) / (freedom * freedom);
    if (score < best_score) {
      best_score = score;
      best_weight = weight;
      best = curve;
    }
  }
  curve = best;
  return best_weight;
}

// Pools adjacent violators, then keeps the smallest slope that leaves the table invertible.
// Returns the number of codes changed.
int make_rising(std::vector<double>& linear) {
  struct Pool {
    double sum;
    int count;
  };
  std::vector<Pool> pools;
  for (const double value : linear) {
    pools.push_back({value, 1});
    while (pools.size() > 1) {
      const Pool last = pools.back();
      const Pool before = pools[pools.size() - 2];
      if (before.sum / before.count < last.sum / last.count) break;
      pools.pop_back();
      pools.back() = {before.sum + last.sum, before.count + last.count};
    }
  }
  int changed = 0;
  std::size_t at = 0;
  for (const Pool& pool : pools) {
    if (pool.count > 1) changed += pool.count;
    for (int i = 0; i < pool.count; ++i) linear[at++] = pool.sum / pool.count;
  }
  const double least_step = 1e-9;
  for (std::size_t code = 1; code < linear.size(); ++code) {
    linear[code] = std::max(linear[code], linear[code - 1] + least_step);
  }
  return changed;
}

}  // namespace

RecoveredResponse recover_response(const std::vector<ResponseSample>& samples, int bit_depth,
                                   double black_level, const std::string& name) {
  const int top = (1 << bit_depth) - 1;
  double highest = black_level;
  for (const ResponseSample& sample : samples) {
    for (std::size_t j = 0; j < sample.code.size(); ++j) {
      if (sample.valid[j] != 0) highest = std::max(highest, sample.code[j]);
    }
  }
  Curve curve(black_level, bit_depth, unknowns, highest);
  std::vector<Group> groups = usable_groups(samples, curve);

  RecoveredResponse recovered;
  ResponseReport& report = recovered.report;
  report.samples = static_cast<int>(groups.size());
  report.lowest_code = top;
  for (const Group& group : groups) {
    report.observations += static_cast<int>(group.size());
    for (const Observation& seen : group) {
      report.lowest_code = std::min(report.lowest_code, seen.code);
      report.highest_code = std::max(report.highest_code, seen.code);
    }
  }
  if (report.highest_code - report.lowest_code < 0.25 * (top - black_level)) {
    throw InputError(
        name + ": the exposure stacks do not hold enough to recover the camera's response (" +
        std::to_string(report.samples) +
        " blocks seen well in two exposures, over less than a quarter of the code range); " +
        "add exposure times, or set camera.encoding to 'linear' if the frames are.");
  }

  for (int round = 0; round < plain_rounds + huber_rounds + tukey_rounds; ++round) {
    weigh_by_noise(groups, curve);
    if (round >= plain_rounds) {
      const Robust robust = round < plain_rounds + huber_rounds ? Robust::huber : Robust::tukey;
      report.outlier_share = weigh_down_outliers(groups, curve, robust);
    }
    report.smoothness = solve(groups, curve);
  }
  double squares = 0.0;
  double weights = 0.0;
  for_each_residual(groups, curve, [&](const Observation& seen, double residual) {
    squares += seen.weight * residual * residual;
    weights += seen.weight;
  });
  report.residual_rms = weights > 0.0 ? std::sqrt(squares / weights) : 0.0;

  recovered.linear.resize(static_cast<std::size_t>(top) + 1);
  for (int code = 0; code <= top; ++code) {
    recovered.linear[static_cast<std::size_t>(code)] = curve.linear(code);
  }
  report.pooled_codes = make_rising(recovered.linear);
  const double scale = recovered.linear.back();
  for (double& value : recovered.linear) value /= scale;
  return recovered;
}

}  // namespace kappamu::capture
