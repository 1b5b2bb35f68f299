#include "inverse/data_checks/gradient_check.h"

#include <cmath>
#include <numeric>
#include <random>

#include "core/error.h"
#include "inverse/block_model/homogeneous.h"

namespace kappamu::inverse {

namespace {

constexpr double solver_tolerance = 1e-12;
/// The test medium's deviation from the homogeneous one, in units of log.
constexpr double roughness_of_medium = 0.2;
/// Below the first step third-order terms are small, above the last rounding is.
constexpr double first_step = 1e-2;
constexpr int decades = 3;

/// Normal numbers, the same on every platform (Box-Muller).
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : engine_(seed) {}
  std::vector<double> operator()(std::size_t count) {
    std::vector<double> values(count);
    for (double& x : values) {
      const double radius = std::sqrt(-2.0 * std::log(uniform()));
      x = radius * std::cos(2.0 * 3.14159265358979323846 * uniform());
    }
    return values;
  }

 private:
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }
  std::mt19937_64 engine_;
};

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

double dot(const CoefficientPair& a, const CoefficientPair& b) {
  return dot(a.log_kappa, b.log_kappa) + dot(a.log_mu, b.log_mu);
}

CoefficientPair moved(const CoefficientPair& from, double step, const CoefficientPair& direction) {
  CoefficientPair to = from;
  for (std::size_t i = 0; i < to.log_mu.size(); ++i) {
    to.log_kappa[i] += step * direction.log_kappa[i];
    to.log_mu[i] += step * direction.log_mu[i];
  }
  return to;
}

double value_at(Objective& objective, const CoefficientPair& fields) {
  const double value = objective.value(fields);
  if (!std::isfinite(value)) {
    throw InputError(
        "the gradient cannot be checked: a forward solve in double precision did not converge; "
        "look at the measurements with `kappamu fit` first");
  }
  return value;
}

void taylor_test(Objective& objective, const CoefficientPair& at, const CoefficientPair& direction,
                 GradientCheck& check) {
  const double value = value_at(objective, at);
  const double slope = dot(objective.gradient(), direction);
  check.directional_derivative = slope / value;
  for (int k = 0; k <= decades; ++k) {
    TaylorStep next;
    next.step = first_step * std::pow(10.0, -k);
    const double there = value_at(objective, moved(at, next.step, direction));
    next.remainder = std::abs(there - value - next.step * slope) / value;
    if (k > 0) {
      next.order = std::log10(check.taylor.back().remainder / next.remainder);
      const double error = std::abs(next.order - 2.0);
      // A NaN must not pass for a small error.
      if (!(error <= check.worst_order_error)) check.worst_order_error = error;
    }
    check.taylor.push_back(next);
  }
}

double adjoint_error(Objective& objective, const CoefficientPair& at,
                     const CoefficientPair& direction, const std::vector<double>& probe) {
  const auto weighted = [&](double step) {
    value_at(objective, moved(at, step, direction));
    const std::vector<double> prediction = objective.prediction();
    double sum = 0.0;
    for (std::size_t i = 0; i < prediction.size(); ++i) {
      sum += probe[i] * std::sqrt(objective.problem().weight[i]) * prediction[i];
    }
    return sum;
  };
  // Richardson's central difference is exact to step⁴.
  constexpr double step = 1e-3;
  const double narrow = (weighted(step) - weighted(-step)) / (2.0 * step);
  const double wide = (weighted(2.0 * step) - weighted(-2.0 * step)) / (4.0 * step);
  const double by_differences = (4.0 * narrow - wide) / 3.0;
  value_at(objective, at);
  return std::abs(by_differences / dot(objective.jacobian_transpose(probe), direction) - 1.0);
}

double symmetry_error(const forward::GridSetup& setup, const Backend& backend,
                      const CoefficientPair& at, Normal& normal) {
  const forward::SolverChoice choice =
      forward::make_grid_solver(setup, backend.device, backend.precision);
  choice.solver->set_medium(exponential(at.log_kappa), exponential(at.log_mu));
  const auto positive = [&] {
    std::vector<double> values = normal(setup.shape.cells());
    for (double& x : values) x = std::abs(x);
    return values;
  };
  const std::vector<double> b = positive();
  const std::vector<double> w = positive();
  const auto solved = [&](const std::vector<double>& right) {
    const auto rhs = choice.solver->make_field(1);
    const auto phi = choice.solver->make_field(1);
    choice.solver->fill(*rhs, right);
    choice.solver->solve(*rhs, *phi, backend.solve);
    std::vector<double> values(right.size());
    choice.solver->read(*phi, values);
    return values;
  };
  return std::abs(dot(solved(b), w) / dot(b, solved(w)) - 1.0);
}

}  // namespace

bool GradientCheck::taylor_holds() const {
  return !taylor.empty() && worst_order_error <= GradientBounds::order;
}

bool GradientCheck::adjoint_holds() const {
  return adjoint_error <= GradientBounds::adjoint;
}

bool GradientCheck::symmetry_holds() const {
  return symmetry_error <= GradientBounds::symmetry;
}

GradientCheck check_gradient(const Problem& problem, const std::string& device,
                             std::uint64_t seed) {
  Backend backend;
  backend.device = device;
  backend.precision = forward::Precision::double_precision;
  backend.solve = {solver_tolerance, 2000};
  Objective objective(problem, backend);
  const HomogeneousFit start = fit_homogeneous(objective);
  const std::size_t cells = problem.setup.shape.cells();
  Normal normal(seed);
  CoefficientPair at{normal(cells), normal(cells)};
  for (double& x : at.log_kappa) x = std::log(start.kappa) + roughness_of_medium * x;
  for (double& x : at.log_mu) x = std::log(start.mu) + roughness_of_medium * x;
  const CoefficientPair direction{normal(cells), normal(cells)};
  const std::vector<double> probe = normal(problem.data.size());

  GradientCheck check;
  taylor_test(objective, at, direction, check);
  check.adjoint_error = adjoint_error(objective, at, direction, probe);
  check.symmetry_error = symmetry_error(problem.setup, backend, at, normal);
  check.solves = objective.solves();
  check.backend = objective.backend_name();
  check.warning = objective.warning();
  return check;
}

}  // namespace kappamu::inverse
