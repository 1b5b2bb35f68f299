// The linear solver in OpenCL against the one on the host: same equations, same cycle.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/numbers/relative_difference.h"
#include "device/device_info.h"
#include "embedded_test_tools.h"
#include "forward/embedded/discretisation.h"
#include "forward/embedded/equations/row_levels.h"

namespace kappamu::forward::embedded {
namespace {

device::Context& context() {
  return device::Context::chosen("auto");
}

/// Random voxels of 1.25 mm, κ log-uniform over a contrast of 100.
ObjectMedium random_medium(unsigned seed) {
  const GridShape shape{16, 16, 16, 1.25};
  auto volume = std::make_shared<Medium>(Medium{Volume<double>(shape), Volume<double>(shape)});
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (std::size_t k = 0; k < shape.cells(); ++k) {
    volume->kappa[k] = 0.3 * std::pow(10.0, uniform(generator));
    volume->mu[k] = 0.02 * (1.0 + uniform(generator));
  }
  return ObjectMedium(volume, Eigen::Affine3d::Identity(), Wrap::mirror);
}

/// A cut sphere with level jumps in several media.
struct System {
  TriangleMesh mesh = icosphere(9.0, 3, {10.1, 9.9, 10.2});
  Discretisation d;

  explicit System(const std::vector<ObjectMedium>& media) : d(made(mesh, media)) {}
  static Discretisation made(const TriangleMesh& mesh, const std::vector<ObjectMedium>& media) {
    std::vector<const ObjectMedium*> pointers;
    for (const ObjectMedium& medium : media) pointers.push_back(&medium);
    Octree tree(mesh);
    tree.refine_surface(5);
    CutMesh cut = cut_mesh(tree, mesh, *make_caster(mesh));
    return Discretisation(std::move(tree), std::move(cut), pointers, boundary_constants(1.3).A);
  }
  Load light(std::size_t channel, std::size_t triangle) const {
    Load load{channel, std::vector<double>(d.levels.unknowns(), 0.0)};
    std::vector<double> flux(mesh.triangles.size(), 0.0);
    flux[triangle] = 1.0;
    add_surface_load(d.mesh, d.space(), flux, load.power);
    return load;
  }
  std::vector<double> on_surface(const std::vector<double>& x) const {
    return triangle_means(d.mesh, d.space(), x, mesh.triangles.size());
  }
};

void expect_equal(const System& system, const std::vector<Load>& loads,
                  std::optional<std::size_t> slice = {}) {
  constexpr double tolerance = 1e-8;  // of the residual, far below what may differ
  constexpr double most_difference = 1e-5;
  std::vector<std::vector<double>> reference, opencl;
  const CgReport a = linear::make_host_solver(row_levels_of(system.d.levels))
                         ->solve(loads, reference, {tolerance, 50});
  const CgReport b = linear::make_opencl_solver(row_levels_of(system.d.levels), context(), slice)
                         ->solve(loads, opencl, {tolerance, 50});
  EXPECT_TRUE(a.converged && b.converged);
  EXPECT_NEAR(a.iterations, b.iterations, 1);
  ASSERT_EQ(reference.size(), opencl.size());
  for (std::size_t l = 0; l < loads.size(); ++l) {
    // On the surface: values of unknowns that belong to vanishing cuts alone weigh nothing.
    EXPECT_LE(relative_difference(system.on_surface(opencl[l]), system.on_surface(reference[l])),
              most_difference)
        << l;
    EXPECT_LE(b.residual[l], 2.0 * tolerance) << l;
  }
}

class EmbeddedOpencl : public testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }
};

TEST_F(EmbeddedOpencl, SolvesAsTheReferenceForOneLightOfEachMedium) {
  const System system({random_medium(1), random_medium(2), ObjectMedium({0.2, 0.05})});
  expect_equal(system, {system.light(0, 10), system.light(1, 500), system.light(2, 900)});
}

TEST_F(EmbeddedOpencl, SolvesAsTheReferenceForSeveralLightsOfAMedium) {
  const System system({random_medium(3)});
  for (const std::size_t lights : {1U, 2U, 5U, 9U}) {
    std::vector<Load> loads;
    for (std::size_t l = 0; l < lights; ++l) loads.push_back(system.light(0, 100 * l));
    expect_equal(system, loads);
  }
}

TEST_F(EmbeddedOpencl, SolvesAsTheReferenceForUnequalNumbersOfLights) {
  const System system({random_medium(4), random_medium(5)});
  expect_equal(system, {system.light(0, 10), system.light(1, 500), system.light(1, 900)});
}

TEST_F(EmbeddedOpencl, SlicesOfRowsChangeNothing) {
  // GPUs have slices of 32 rows; 7 leaves a remainder.
  const System system({random_medium(7), random_medium(8)});
  for (const std::size_t slice : {7U, 32U}) {
    expect_equal(system, {system.light(0, 10), system.light(1, 500)}, slice);
  }
}

/// The device computes its step lengths itself, and the host looks at some iterations only: as many
/// iterations give what they give on the host.
TEST_F(EmbeddedOpencl, EachIterationIsThatOfTheHost) {
  const System system({random_medium(9), random_medium(10)});
  const std::vector<Load> loads{system.light(0, 10), system.light(1, 500)};
  const auto host = linear::make_host_solver(row_levels_of(system.d.levels));
  for (const std::size_t slice : {1U, 32U}) {
    const auto opencl =
        linear::make_opencl_solver(row_levels_of(system.d.levels), context(), slice);
    for (const int iterations : {0, 1, 2, 3, 5, 8}) {
      std::vector<std::vector<double>> reference, x;
      EXPECT_FALSE(host->solve(loads, reference, {1e-15, iterations}).converged);
      const CgReport report = opencl->solve(loads, x, {1e-15, iterations});
      EXPECT_FALSE(report.converged);
      EXPECT_EQ(report.iterations, iterations);
      for (std::size_t l = 0; l < loads.size(); ++l) {
        EXPECT_LE(relative_difference(system.on_surface(x[l]), system.on_surface(reference[l])),
                  1e-5)
            << iterations << " iterations, light " << l;
      }
    }
  }
}

/// Whatever the tolerance, no light stops above it, nor an iteration later than on the host.
TEST_F(EmbeddedOpencl, StopsWhereTheHostStops) {
  const System system({random_medium(11), ObjectMedium({0.3, 0.02})});
  const std::vector<Load> loads{system.light(0, 10), system.light(1, 500)};
  const auto host = linear::make_host_solver(row_levels_of(system.d.levels));
  const auto opencl = linear::make_opencl_solver(row_levels_of(system.d.levels), context(), 32);
  for (double tolerance = 0.3; tolerance > 1e-8; tolerance *= 0.3) {
    std::vector<std::vector<double>> reference, x;
    const CgReport a = host->solve(loads, reference, {tolerance, 60});
    const CgReport b = opencl->solve(loads, x, {tolerance, 60});
    EXPECT_TRUE(a.converged && b.converged);
    EXPECT_NEAR(a.iterations, b.iterations, 1) << tolerance;
    for (const double residual : b.residual) EXPECT_LE(residual, 2.0 * tolerance);
  }
}

TEST_F(EmbeddedOpencl, ALightWithoutPowerStaysDark) {
  const System system({ObjectMedium({0.3, 0.01})});
  std::vector<Load> loads{system.light(0, 10), system.light(0, 10)};
  std::fill(loads[1].power.begin(), loads[1].power.end(), 0.0);
  std::vector<std::vector<double>> x;
  EXPECT_TRUE(linear::make_opencl_solver(row_levels_of(system.d.levels), context())
                  ->solve(loads, x, {1e-6, 50})
                  .converged);
  for (const double value : x[1]) ASSERT_EQ(value, 0.0);
}

TEST_F(EmbeddedOpencl, ThePowersBalanceWhateverTheTolerance) {
  const System system({random_medium(6)});
  const std::vector<Load> loads{system.light(0, 10)};
  std::vector<std::vector<double>> x;
  linear::make_opencl_solver(row_levels_of(system.d.levels), context())->solve(loads, x, {0.1, 50});
  double given = 0.0, taken = 0.0;
  for (const double power : loads[0].power) given += power;
  taken = absorbed_power(system.d.mesh, system.d.space(), system.d.coefficients[0], x[0]);
  const Surface surface = surface_of(system.mesh);
  const std::vector<double> means = system.on_surface(x[0]);
  for (std::size_t t = 0; t < means.size(); ++t) {
    taken += means[t] * surface.area[t] / (2.0 * boundary_constants(1.3).A);
  }
  EXPECT_NEAR(taken / given, 1.0, 1e-6);
}

}  // namespace
}  // namespace kappamu::forward::embedded
