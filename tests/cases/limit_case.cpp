#include "tests/cases/limit_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "forward/diffusion_warnings.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/power_balance.h"

namespace kappamu::test_cases {

namespace {

using forward::GridSetup;
using Wide = std::vector<long double>;

/// The equations of grid_solver.h once more, in long double, for residuals only.
class WideEquations {
 public:
  WideEquations(const GridSetup& setup, const Medium& medium, long double robin_A)
      : setup_(setup), medium_(medium), two_a_(2.0L * robin_A) {}

  /// b − Aφ, rounded to double.
  std::vector<double> residual(const double* b, const Wide& phi) const {
    const GridShape& s = setup_.shape;
    const long double h = s.voxel_mm;
    std::vector<double> r(s.cells());
    for (int z = 0; z < s.nz; ++z) {
      for (int y = 0; y < s.ny; ++y) {
        for (int x = 0; x < s.nx; ++x) {
          const std::size_t i = s.index(x, y, z);
          long double power = b[i] - static_cast<long double>(medium_.mu[i]) * h * h * h * phi[i];
          const std::array<int, 3> at{x, y, z};
          for (const Face face : all_faces) {
            const int axis = axis_of(face);
            const int next = at[static_cast<std::size_t>(axis)] + (is_plus(face) ? 1 : -1);
            if (next < 0 || next >= s.extent(axis)) {
              if (is_open(setup_, face)) power -= robin(i) * phi[i];
              continue;
            }
            std::array<int, 3> to = at;
            to[static_cast<std::size_t>(axis)] = next;
            const std::size_t j = s.index(to[0], to[1], to[2]);
            power -= conductance(i, j) * (phi[i] - phi[j]);
          }
          r[i] = static_cast<double>(power);
        }
      }
    }
    return r;
  }

 private:
  long double conductance(std::size_t i, std::size_t j) const {
    const long double a = medium_.kappa[i], b = medium_.kappa[j];
    return setup_.shape.voxel_mm * 2.0L * a * b / (a + b);
  }
  long double robin(std::size_t i) const {
    const long double h = setup_.shape.voxel_mm;
    return h * h / (h / (2.0L * medium_.kappa[i]) + two_a_);
  }

  const GridSetup& setup_;
  const Medium& medium_;
  long double two_a_;
};

double norm(const double* values, std::size_t count) {
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += values[i] * values[i];
  return std::sqrt(sum);
}

}  // namespace

std::string to_string(forward::Termination termination) {
  switch (termination) {
    case forward::Termination::converged:
      return "converged";
    case forward::Termination::ran_out:
      return "ran out";
    case forward::Termination::failed:
      return "failed";
  }
  throw InternalError("to_string: unknown termination");
}

double worst_difference(const std::vector<double>& a, const std::vector<double>& b, int patterns) {
  check(a.size() == b.size(), "worst_difference: different sizes");
  const std::size_t n = a.size() / static_cast<std::size_t>(patterns);
  double worst = 0.0;
  for (std::size_t m = 0; m < static_cast<std::size_t>(patterns); ++m) {
    double distance = 0.0;
    for (std::size_t i = m * n; i < (m + 1) * n; ++i) distance += (a[i] - b[i]) * (a[i] - b[i]);
    const double size = norm(b.data() + m * n, n);
    const double relative = std::sqrt(distance) / (size > 0.0 ? size : 1.0);
    if (!(relative <= worst)) worst = relative;  // carries NaN on
  }
  return worst;
}

std::vector<double> converged_fluence(const GridSetup& setup, const Medium& medium,
                                      const std::vector<double>& irradiance, int patterns) {
  constexpr double enough = 1e-13;
  constexpr int most_refinements = 12;
  // Each refinement gains what one solve in double can: a modest tolerance always reached.
  const forward::SolveOptions one_solve{1e-9, 20000};
  const auto solver = forward::make_reference_solver(setup);
  solver->set_medium(medium.kappa.values(), medium.mu.values());
  const std::size_t n = setup.shape.cells();
  std::vector<double> sources(n * static_cast<std::size_t>(patterns));
  const auto light = solver->make_field(patterns);
  solver->light_source(irradiance, *light);
  solver->read(*light, sources);

  const WideEquations equations(setup, medium, solver->constants().A);
  const auto rhs = solver->make_field(1), correction = solver->make_field(1);
  std::vector<double> phi(sources.size()), change(n);
  const std::vector<double> zero(n, 0.0);
  for (std::size_t m = 0; m < static_cast<std::size_t>(patterns); ++m) {
    Wide total(n, 0.0L);
    bool done = norm(&sources[m * n], n) == 0.0;
    for (int k = 0; k < most_refinements && !done; ++k) {
      solver->fill(*rhs, equations.residual(&sources[m * n], total));
      solver->fill(*correction, zero);
      solver->solve(*rhs, *correction, one_solve);
      solver->read(*correction, change);
      long double size = 0.0L;
      for (std::size_t i = 0; i < n; ++i) {
        total[i] += change[i];
        size += total[i] * total[i];
      }
      done = norm(change.data(), n) <= enough * std::sqrt(static_cast<double>(size));
    }
    check(done, "converged_fluence: refinement did not converge");
    std::copy(total.begin(), total.end(), phi.begin() + static_cast<std::ptrdiff_t>(m * n));
  }
  return phi;
}

LimitOutcome run_limit(const LimitCase& limit) {
  const GridSetup& setup = limit.setup;
  const Medium medium = make_medium(setup.shape, limit.medium);
  const std::vector<double> light = patch_light(setup.shape, setup.lit_face, limit.patterns);
  const auto patterns = static_cast<std::size_t>(limit.patterns);
  const forward::SolverChoice choice =
      forward::make_grid_solver(setup, limit.device, limit.precision);
  forward::GridSolver& solver = *choice.solver;
  solver.set_medium(medium.kappa.values(), medium.mu.values());
  const auto b = solver.make_field(limit.patterns), phi = solver.make_field(limit.patterns);
  solver.light_source(light, *b);
  const forward::SolveReport report = solver.solve(*b, *phi, limit.options);

  LimitOutcome outcome;
  outcome.termination = report.termination;
  outcome.iterations = report.iterations;
  outcome.residual = *std::max_element(report.residual.begin(), report.residual.end());
  outcome.message = report.message;
  outcome.warnings = forward::diffusion_warnings(setup, medium, limit.precision);
  if (!choice.warning.empty()) outcome.warnings.push_back(choice.warning);

  const auto exitance = [&](const forward::GridSolver& of, const forward::BatchField& field,
                            Face face) {
    std::vector<double> map(face_shape(setup.shape, face).cells() * patterns);
    of.exitance(field, face,
                face == setup.lit_face ? std::span<const double>(light) : std::span<const double>(),
                map);
    return map;
  };
  std::array<std::vector<double>, 6> maps;
  for (std::size_t f = 0; f < all_faces.size(); ++f) {
    maps[f] = exitance(solver, *phi, all_faces[f]);
  }
  double entering = 0.0;
  const auto lit = static_cast<std::size_t>(setup.lit_face);
  const Face far = opposite(setup.lit_face);
  for (const auto& balance : forward::power_balance(solver, medium, *phi, light, maps)) {
    const double out = std::accumulate(balance.exiting.begin(), balance.exiting.end(), 0.0) +
                       balance.unscattered + balance.absorbed;
    const double off = std::abs(out - balance.entering) / balance.entering;
    if (!(off <= outcome.imbalance)) outcome.imbalance = off;
    entering += balance.entering;
    outcome.reflected += balance.exiting[lit];
    outcome.transmitted += balance.exiting[static_cast<std::size_t>(far)];
  }
  outcome.reflected /= entering;
  outcome.transmitted /= entering;

  if (limit.with_error) {
    const std::vector<double> truth = converged_fluence(setup, medium, light, limit.patterns);
    std::vector<double> values(truth.size());
    solver.read(*phi, values);
    outcome.true_error = worst_difference(values, truth, limit.patterns);
    const auto reference = forward::make_reference_solver(setup);
    reference->set_medium(medium.kappa.values(), medium.mu.values());
    const auto exact = reference->make_field(limit.patterns);
    reference->fill(*exact, truth);
    outcome.dark_error = worst_difference(maps[static_cast<std::size_t>(far)],
                                          exitance(*reference, *exact, far), limit.patterns);
  }
  return outcome;
}

}  // namespace kappamu::test_cases
