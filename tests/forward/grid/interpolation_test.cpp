// A coarse grid's light on voxels of half the edge, which a solve there begins with.
#include <gtest/gtest.h>

#include <array>

#include "tests/forward/grid/backends.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Values;

/// An odd number of fine voxels leaves the last coarse one half outside.
constexpr GridShape fine{15, 12, 9, 0.25};
constexpr GridShape coarse{8, 6, 5, 0.5};

class Interpolation : public testing::OnBackend {
 protected:
  static Values carried(const Values& from, int patterns, int first, int wanted) {
    const auto below = solver({.shape = coarse}), above = solver({.shape = fine});
    const auto given = below->make_field(patterns), found = above->make_field(wanted);
    below->fill(*given, from);
    above->interpolate(*given, coarse, first, *found);
    return testing::read(*above, *found);
  }
};

TEST_P(Interpolation, CarriesALinearFieldExactlyOffTheRim) {
  const std::array<double, 3> slope{0.3, -0.7, 0.2};
  const auto at = [&](const GridShape& shape, int x, int y, int z) {
    const double h = shape.voxel_mm;
    return 2.0 + slope[0] * (x + 0.5) * h + slope[1] * (y + 0.5) * h + slope[2] * (z + 0.5) * h;
  };
  Values from(coarse.cells());
  for (int z = 0; z < coarse.nz; ++z) {
    for (int y = 0; y < coarse.ny; ++y) {
      for (int x = 0; x < coarse.nx; ++x) from[coarse.index(x, y, z)] = at(coarse, x, y, z);
    }
  }
  const Values found = carried(from, 1, 0, 1);
  for (int z = 1; z + 1 < fine.nz; ++z) {
    for (int y = 1; y + 1 < fine.ny; ++y) {
      for (int x = 1; x + 1 < fine.nx; ++x) {
        ASSERT_NEAR(found[fine.index(x, y, z)], at(fine, x, y, z), 4.0 * rounding());
      }
    }
  }
  // At the rim the outermost coarse cell goes on.
  EXPECT_NEAR(found[0], from[0], 4.0 * rounding());
}

TEST_P(Interpolation, TakesThePatternsThatAreAskedFor) {
  constexpr int patterns = 16, first = 8, wanted = 8;
  const Values all = testing::random_values(coarse.cells() * patterns, 0.0, 1.0, 5);
  const Values found = carried(all, patterns, first, wanted);
  for (int m = 0; m < wanted; ++m) {
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(coarse.cells()) * (first + m);
    const Values alone =
        carried({begin, begin + static_cast<std::ptrdiff_t>(coarse.cells())}, 1, 0, 1);
    for (std::size_t i = 0; i < fine.cells(); ++i) {
      ASSERT_NEAR(found[fine.cells() * static_cast<std::size_t>(m) + i], alone[i], rounding());
    }
  }
}

/// Light of one medium on both grids: the guess is worth an iteration, and the answer is the same.
TEST_P(Interpolation, SavesAnIterationOfASolve) {
  constexpr GridShape body{20, 16, 12, 0.5};
  const GridShape split = body.refined(2);
  constexpr int patterns = 3;
  constexpr SolveOptions options{1e-4, 100};
  const auto below = solver({.shape = body}), above = solver({.shape = split});
  const auto even = [](const GridSolver& s) { return Values(s.setup().shape.cells(), 0.2); };
  const auto weak = [](const GridSolver& s) { return Values(s.setup().shape.cells(), 0.02); };
  below->set_medium(even(*below), weak(*below));
  above->set_medium(even(*above), weak(*above));
  const std::size_t pixels = face_shape(body, below->setup().lit_face).cells();
  const Values light(pixels * patterns, 1.0), fine_light(4 * pixels * patterns, 1.0);
  const auto known = testing::solve_light(*below, light, patterns, options);
  const auto cold = testing::solve_light(*above, fine_light, patterns, options);
  const auto b = above->make_field(patterns), phi = above->make_field(patterns);
  above->light_source(fine_light, *b);
  above->interpolate(*known.phi, body, 0, *phi);
  const SolveReport report = above->solve(*b, *phi, options);
  ASSERT_EQ(report.termination, Termination::converged) << report.message;
  EXPECT_LT(report.iterations, cold.report.iterations);
  EXPECT_LT(
      testing::relative_difference(testing::read(*above, *phi), testing::read(*above, *cold.phi)),
      3.0 * options.tolerance);
}

INSTANTIATE_TEST_SUITE_P(On, Interpolation,
                         ::testing::Values(testing::reference_backend, testing::opencl_single,
                                           testing::opencl_double),
                         testing::backend_name);

/// Light that is not there, or of another kind of solver, is no guess.
TEST(InterpolationBetweenBackends, LeavesTheFieldZero) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  const auto host = make_grid_solver({.shape = coarse}, "reference").solver;
  const auto above = make_grid_solver({.shape = fine}, "auto").solver;
  const auto given = host->make_field(2), found = above->make_field(2);
  host->fill(*given, Values(2 * coarse.cells(), 1.0));
  above->interpolate(*given, coarse, 0, *found);
  EXPECT_EQ(testing::read(*above, *found), Values(2 * fine.cells(), 0.0));
}

}  // namespace
}  // namespace kappamu::forward
