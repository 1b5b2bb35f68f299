// The solver in OpenCL against the serial reference: same equations, other method.
#include <gtest/gtest.h>

#include <random>

#include "core/optics.h"
#include "device/device_info.h"
#include "forward/polygrid/opencl/opencl_solver.h"
#include "tests/cases/made_polygrid.h"
#include "tests/cases/polygrid_reference.h"

namespace kappamu::forward::polygrid {
namespace {

using Vector = std::vector<double>;

device::Context& context() {
  return device::Context::chosen("auto");
}

struct System {
  Polygrid grid;
  Equations equations;
  Hierarchy hierarchy;
  std::vector<MediumValues> media;

  System(Polygrid made, int channels)
      : grid(std::move(made)),
        equations(grid, boundary_constants(1.3).A),
        hierarchy(equations, grid) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> power(-1.0, 1.0);
    for (int c = 0; c < channels; ++c) {
      std::vector<Coefficients> drawn;
      for (std::size_t k = 0; k < grid.cell.size(); ++k) {
        drawn.push_back(
            {0.2 * std::pow(10.0, power(random)), 0.02 * std::pow(10.0, power(random))});
      }
      media.push_back(equations.values(drawn));
    }
  }
  Load load(std::size_t channel, unsigned seed) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    Load load{channel, Vector(equations.unknowns(), 0.0)};
    for (std::size_t i = 0; i < load.power.size(); ++i) {
      load.power[i] = equations.boundary_share()[i] * uniform(random);
    }
    return load;
  }
};

double relative_difference(const Vector& a, const Vector& b) {
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    size += b[i] * b[i];
  }
  return std::sqrt(difference / size);
}

void expect_equal(const System& system, const std::vector<Load>& loads, Precision precision,
                  double tolerance, double most_difference, std::optional<device::Kind> form = {}) {
  const auto reference = make_reference_solver(system.equations);
  const auto opencl = make_opencl_solver(system.equations, system.hierarchy, context(), precision,
                                         Lights::others, form);
  reference->set_media(system.media);
  opencl->set_media(system.media);
  std::vector<Vector> a, b;
  EXPECT_TRUE(reference->solve(loads, a, 1e-12, 5000).converged);
  const CgReport report = opencl->solve(loads, b, tolerance, 200);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.residual.size(), loads.size());
  for (std::size_t l = 0; l < loads.size(); ++l) {
    EXPECT_LE(relative_difference(b[l], a[l]), most_difference) << "light " << l;
  }
}

TEST(PolygridOpencl, IsEquivalentToTheReference) {
  const System system(bent_polygrid({13, 7, 5}), 3);
  // One light of one medium; three media; many lights of one, more than lanes.
  expect_equal(system, {system.load(1, 1)}, Precision::twofold, 1e-11, 1e-9);
  expect_equal(system, {system.load(0, 1), system.load(1, 2), system.load(2, 3)},
               Precision::twofold, 1e-11, 1e-9);
  std::vector<Load> many;
  for (unsigned l = 0; l < 11; ++l) many.push_back(system.load(l < 9 ? 2 : 0, l));
  expect_equal(system, many, Precision::twofold, 1e-11, 1e-9);
}

// Rows in turn, work-groups of sums, and sums of these on the device.
TEST(PolygridOpencl, InTheFormOfGpusIsEquivalentToTheReference) {
  const System system(bent_polygrid({13, 7, 5}), 3);
  constexpr auto gpu = device::Kind::gpu;
  expect_equal(system, {system.load(1, 1)}, Precision::twofold, 1e-11, 1e-9, gpu);
  expect_equal(system, {system.load(0, 1), system.load(1, 2), system.load(2, 3)},
               Precision::twofold, 1e-11, 1e-9, gpu);
  std::vector<Load> many;
  for (unsigned l = 0; l < 11; ++l) many.push_back(system.load(l < 9 ? 2 : 0, l));
  expect_equal(system, many, Precision::twofold, 1e-11, 1e-9, gpu);
  expect_equal(system, {system.load(0, 1), system.load(1, 2), system.load(2, 3)}, Precision::single,
               1e-5, 1e-4, gpu);
}

TEST(PolygridHost, IsEquivalentToTheReference) {
  for (const System& system :
       {System(bent_polygrid({13, 7, 5}), 3), System(box_polygrid({1, 2, 3}, {1, 1, 1}), 3)}) {
    const auto reference = make_reference_solver(system.equations);
    const auto host = make_host_solver(system.equations, system.hierarchy);
    reference->set_media(system.media);
    host->set_media(system.media);
    const std::vector<Load> loads{system.load(0, 1), system.load(1, 2), system.load(2, 3)};
    std::vector<Vector> a, b;
    EXPECT_TRUE(reference->solve(loads, a, 1e-12, 5000).converged);
    EXPECT_TRUE(host->solve(loads, b, 1e-11, 200).converged);
    for (std::size_t l = 0; l < loads.size(); ++l) {
      EXPECT_LE(relative_difference(b[l], a[l]), 1e-9) << "light " << l;
    }
  }
}

// Iterations hardly grow with the number of cells on the host either.
TEST(PolygridHost, TakesFewIterationsOnEveryResolution) {
  for (const auto& [n, most] : {std::pair{8, 26}, {16, 30}, {32, 34}}) {
    const System system(bent_polygrid({n, n, n / 2}), 1);
    const auto solver = make_host_solver(system.equations, system.hierarchy);
    const std::vector<Coefficients> plain(system.grid.cell.size(), {0.2, 0.002});
    solver->set_media({system.equations.values(plain)});
    std::vector<Vector> x;
    const CgReport report = solver->solve({system.load(0, 1)}, x, 1e-5, 100);
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.iterations, most) << n;
  }
}

TEST(PolygridOpencl, SinglePrecisionIsEnoughForPictures) {
  const System system(ball_polygrid(12, 5.0), 3);
  expect_equal(system, {system.load(0, 1), system.load(1, 2), system.load(2, 3)}, Precision::single,
               1e-5, 1e-4);
}

TEST(PolygridOpencl, SolvesWhatIsTooSmallForLevels) {
  const System system(box_polygrid({1, 2, 3}, {1, 1, 1}), 2);
  ASSERT_EQ(system.hierarchy.level().size(), 1U);
  expect_equal(system, {system.load(0, 1), system.load(1, 2)}, Precision::twofold, 1e-11, 1e-9);
}

// From the last answer: the same light takes no iteration, another medium is solved anew.
TEST(PolygridOpencl, StartsFromTheLastAnswer) {
  const System system(ball_polygrid(10, 5.0), 1);
  const auto solver =
      make_opencl_solver(system.equations, system.hierarchy, context(), Precision::single);
  solver->set_media(system.media);
  std::vector<Vector> x;
  const int first = solver->solve({system.load(0, 1)}, x, 1e-4, 100).iterations;
  EXPECT_GT(first, 3);
  EXPECT_EQ(solver->solve({system.load(0, 1)}, x, 1.1e-4, 100).iterations, 0);
  Load dimmed = system.load(0, 1);
  for (double& p : dimmed.power) p *= 0.98;
  EXPECT_LT(solver->solve({dimmed}, x, 1e-4, 100).iterations, first);
}

/// √(vᵀ A v).
double energy_norm(const System& system, const Vector& v) {
  const Pattern& pattern = system.equations.matrix();
  double sum = 0.0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    for (int k = pattern.start[i]; k < pattern.start[i + 1]; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const auto j = static_cast<std::size_t>(pattern.column[at]);
      sum += (i == j ? 1.0 : 2.0) * system.media[0].value[at] * v[i] * v[j];
    }
  }
  return std::sqrt(sum);
}

class PolygridOpenclForm : public testing::TestWithParam<device::Kind> {};
INSTANTIATE_TEST_SUITE_P(Forms, PolygridOpenclForm,
                         testing::Values(device::Kind::cpu, device::Kind::gpu));

// However few iterations it takes: the error, in the norm stated, is what the solver says.
TEST_P(PolygridOpenclForm, EndsWithinItsTolerance) {
  const System system(ball_polygrid(14, 5.0), 1);
  const auto reference = make_reference_solver(system.equations);
  const auto opencl = make_opencl_solver(system.equations, system.hierarchy, context(),
                                         Precision::single, Lights::moving, GetParam());
  reference->set_media(system.media);
  opencl->set_media(system.media);
  std::vector<Vector> exact, x;
  int frame = 0;
  for (const double tolerance : {0.1, 0.02, 0.02, 0.02, 1e-3}) {
    Load load = system.load(0, 1);
    for (std::size_t i = 0; i < load.power.size(); ++i) {
      load.power[i] *= 1.0 + 0.3 * std::sin(0.1 * frame + system.grid.corner[i].x());
    }
    ++frame;
    reference->solve({load}, exact, 1e-10, 5000);
    const CgReport report = opencl->solve({load}, x, tolerance, 100);
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.residual[0], tolerance);
    Vector error = x[0];
    for (std::size_t i = 0; i < error.size(); ++i) error[i] -= exact[0][i];
    EXPECT_LE(energy_norm(system, error), tolerance * energy_norm(system, exact[0])) << tolerance;
  }
}

// Of more rows than a GPU's form has work-items: an item's rows lie far apart.
TEST(PolygridOpencl, BothFormsFindTheSameWhereAnItemHasSeveralRows) {
  const System system(box_polygrid({33, 33, 33}, {5, 5, 5}), 3);
  ASSERT_GT(system.equations.unknowns(), 32768U);
  std::vector<std::vector<Vector>> found;
  for (const device::Kind form : {device::Kind::cpu, device::Kind::gpu}) {
    const auto solver = make_opencl_solver(system.equations, system.hierarchy, context(),
                                           Precision::single, Lights::moving, form);
    solver->set_media(system.media);
    std::vector<Vector> x;
    for (const unsigned seed : {1U, 2U}) {
      EXPECT_TRUE(solver
                      ->solve({system.load(0, seed), system.load(1, seed), system.load(2, seed)}, x,
                              1e-4, 100)
                      .converged);
    }
    found.push_back(x);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    Vector difference = found[0][c];
    for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= found[1][c][i];
    EXPECT_LT(energy_norm(system, difference), 1e-3 * energy_norm(system, found[0][c])) << c;
  }
}

// Iterations hardly grow with the number of cells.
TEST(PolygridMultigrid, TakesFewIterationsOnEveryResolution) {
  for (const auto& [n, most] : {std::pair{8, 24}, {16, 26}, {32, 30}}) {
    const System system(bent_polygrid({n, n, n / 2}), 1);
    const auto solver =
        make_opencl_solver(system.equations, system.hierarchy, context(), Precision::single);
    const std::vector<Coefficients> plain(system.grid.cell.size(), {0.2, 0.002});
    solver->set_media({system.equations.values(plain)});
    std::vector<Vector> x;
    const CgReport report = solver->solve({system.load(0, 1)}, x, 1e-5, 100);
    EXPECT_TRUE(report.converged);
    EXPECT_LE(report.iterations, most) << n;
    RecordProperty("iterations_" + std::to_string(n), report.iterations);
  }
}

// Coarse levels are the seven-point form of the coarser box, away from its boundary.
TEST(PolygridMultigrid, CoarseLevelsAreThoseOfTheCoarserBox) {
  const int n = 15;  // 16 corners an edge
  const Polygrid fine = box_polygrid({n, n, n}, {3, 3, 3});
  const Equations equations(fine, 2.0);
  const Hierarchy hierarchy(equations, fine);
  const std::vector<Coefficients> plain(fine.cell.size(), {0.3, 0.0});
  const std::vector<GraphValues> values = hierarchy.values(equations.values(plain));
  ASSERT_GE(values.size(), 2U);
  const double h = 3.0 / n;
  double largest = 0.0;
  for (const double w : values[1].link) largest = std::max(largest, w);
  EXPECT_NEAR(largest, 0.3 * 2.0 * h, 1e-12);
}

}  // namespace
}  // namespace kappamu::forward::polygrid
