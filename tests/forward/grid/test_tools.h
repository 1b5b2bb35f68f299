// Shared by the tests of the grid solvers: media and light with fixed seeds, and one-line solves.
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/numbers/dot.h"
#include "core/numbers/relative_difference.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward::testing {

using Values = std::vector<double>;
using kappamu::relative_difference;

inline Values random_values(std::size_t count, double low, double high, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(low, high);
  Values values(count);
  for (double& v : values) v = uniform(generator);
  return values;
}

/// κ between 0.3/√contrast and 0.3·√contrast [mm], log-uniform and independent per voxel; μ
/// between 0 and 0.05 [1/mm].
struct Coefficients {
  Values kappa, mu;
};
inline Coefficients random_medium(const GridShape& shape, double contrast, unsigned seed) {
  Coefficients c{random_values(shape.cells(), -0.5, 0.5, seed),
                 random_values(shape.cells(), 0.0, 0.05, seed + 1)};
  for (double& k : c.kappa) k = 0.3 * std::pow(contrast, k);
  return c;
}

inline double norm(const Values& a) {
  return std::sqrt(dot(a, a));
}

inline Values read(const GridSolver& solver, const BatchField& field) {
  Values values(solver.setup().shape.cells() * static_cast<std::size_t>(field.patterns()));
  solver.read(field, values);
  return values;
}

inline Values exitance(const GridSolver& solver, const BatchField& phi, Face face,
                       const Values& irradiance) {
  Values out(face_shape(solver.setup().shape, face).cells() *
             static_cast<std::size_t>(phi.patterns()));
  solver.exitance(phi, face, irradiance, out);
  return out;
}

struct Solution {
  std::unique_ptr<BatchField> phi;
  SolveReport report;
};
/// φ under `irradiance` [pattern][v][u].
inline Solution solve_light(const GridSolver& solver, const Values& irradiance, int patterns,
                            const SolveOptions& options) {
  const auto b = solver.make_field(patterns);
  solver.light_source(irradiance, *b);
  Solution solution{solver.make_field(patterns), {}};
  solution.report = solver.solve(*b, *solution.phi, options);
  return solution;
}
/// φ for a given right-hand side [pattern][z][y][x].
inline Solution solve_rhs(const GridSolver& solver, const Values& rhs, int patterns,
                          const SolveOptions& options) {
  const auto b = solver.make_field(patterns);
  solver.fill(*b, rhs);
  Solution solution{solver.make_field(patterns), {}};
  solution.report = solver.solve(*b, *solution.phi, options);
  return solution;
}

}  // namespace kappamu::forward::testing
