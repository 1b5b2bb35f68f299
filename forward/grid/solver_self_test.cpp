#include "forward/grid/solver_self_test.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <mutex>
#include <tuple>
#include <vector>

#include "core/numbers/relative_difference.h"
#include "core/shown_text.h"
#include "device/self_test.h"
#include "forward/grid/opencl/opencl_solver.h"

namespace kappamu::forward {

namespace {

using Values = std::vector<double>;

struct Answers {
  Values exitance, products;
};

/// Exitance of all faces and the gradient's sums, under lights and in a medium without symmetry.
Answers solve_case(GridSolver& solver, int patterns, double tolerance) {
  const GridShape& s = solver.setup().shape;
  Values kappa(s.cells()), mu(s.cells());
  for (std::size_t i = 0; i < s.cells(); ++i) {
    kappa[i] = 0.05 * std::pow(100.0, static_cast<double>(i * 37 % 101) / 100.0);
    mu[i] = 0.001 * static_cast<double>(i * 11 % 17);
  }
  solver.set_medium(kappa, mu);
  const std::size_t lit = face_shape(s, solver.setup().lit_face).cells();
  Values irradiance(lit * static_cast<std::size_t>(patterns));
  for (std::size_t i = 0; i < irradiance.size(); ++i) {
    irradiance[i] = static_cast<double>(i * 29 % 31) / 31.0;
  }
  const auto b = solver.make_field(patterns);
  const auto phi = solver.make_field(patterns);
  solver.light_source(irradiance, *b);
  solver.solve(*b, *phi, {tolerance, 100});
  Answers answers;
  for (const Face face : all_faces) {
    Values map(face_shape(s, face).cells() * static_cast<std::size_t>(patterns));
    solver.exitance(*phi, face, irradiance, map);
    answers.exitance.insert(answers.exitance.end(), map.begin(), map.end());
  }
  const PairProducts sums = solver.pair_products(*phi, *b);
  for (const Values* v : {&sums.cell, &sums.face_x, &sums.face_y, &sums.face_z}) {
    answers.products.insert(answers.products.end(), v->begin(), v->end());
  }
  return answers;
}

Verdict compare(device::Context& context, Precision precision, int lanes) {
  const bool single = precision == Precision::single_precision;
  const double tolerance = single ? 1e-6 : 1e-10;
  // Solver tolerance times the condition of this small block, with room; wrong kernels miss by far
  // more.
  const double allowed = 1e3 * tolerance;
  GridSetup setup;
  setup.shape = {19, 6, 5, 0.5};
  setup.lit_face = Face::y_plus;
  try {
    const auto solver = make_opencl_solver(setup, context, {precision, Trust::blind, {}});
    const Answers found = solve_case(*solver, lanes, tolerance);
    const Answers expected = solve_case(*make_reference_solver(setup), lanes, 1e-12);
    const double worst = std::max(relative_difference(found.exitance, expected.exitance),
                                  relative_difference(found.products, expected.products));
    return {worst <= allowed,  // false for NaN too
            formatted("grid solver, %d pattern%s at once: relative difference from the reference "
                      "%g, allowed %g",
                      lanes, lanes == 1 ? "" : "s", worst, allowed)};
  } catch (const std::exception& error) {
    return {false, error.what()};
  }
}

}  // namespace

const Verdict& solver_verdict(device::Context& context, Precision precision, int lanes) {
  static std::mutex mutex;
  static std::map<std::tuple<device::Context*, Precision, int>, Verdict> verdicts;
  const std::scoped_lock lock(mutex);
  const std::tuple key{&context, precision, lanes};
  const auto found = verdicts.find(key);
  if (found != verdicts.end()) return found->second;
  return verdicts.emplace(key, compare(context, precision, lanes)).first->second;
}

Verdict device_verdict(device::Context& context, Precision precision) {
  static std::mutex mutex;
  static std::map<device::Context*, device::SelfTest> basics;
  std::unique_lock lock(mutex);
  auto found = basics.find(&context);
  if (found == basics.end()) {
    found = basics.emplace(&context, device::self_test(context)).first;
  }
  lock.unlock();
  if (!found->second.passed) return {false, found->second.message};
  const Verdict& solver = solver_verdict(context, precision, full_lanes);
  return {solver.trusted,
          solver.trusted ? found->second.message + "; " + solver.message : solver.message};
}

}  // namespace kappamu::forward
