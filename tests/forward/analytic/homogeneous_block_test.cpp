// The sum of lateral modes against the grid solver, which knows nothing of it: every face of a
// block under patches, with open sides and mirrors, either source.
#include "forward/analytic/homogeneous_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "forward/forward_model.h"

namespace kappamu::forward {
namespace {

constexpr double kappa = 0.4, mu = 0.03;

std::vector<double> patches(FaceShape face, int per_pixel) {
  std::vector<double> light;
  for (int m = 0; m < 2; ++m) {
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const int x = u / per_pixel, y = v / per_pixel;
        light.push_back(m == 0 ? 1.0 : x >= 2 && x < 6 && y < 4 ? 0.8 : 0.1);
      }
    }
  }
  return light;
}

FacePixels all_pixels(FaceShape face) {
  FacePixels pixels{std::vector<int>(static_cast<std::size_t>(face.nu)),
                    std::vector<int>(static_cast<std::size_t>(face.nv))};
  std::iota(pixels.u.begin(), pixels.u.end(), 0);
  std::iota(pixels.v.begin(), pixels.v.end(), 0);
  return pixels;
}

/// Relative root mean square of grid over modes, on a grid of `per_pixel`³ cells a voxel.
double difference(GridSetup setup, Face seen, int per_pixel) {
  const FaceShape coarse = face_shape(setup.shape, seen);
  const std::vector<double> light = patches(face_shape(setup.shape, setup.lit_face), 1);
  HomogeneousBlock block(setup, seen, light, all_pixels(coarse));
  const std::vector<double> modes = block.exitance(kappa, mu);

  ForwardProblem problem;
  setup.shape = setup.shape.refined(per_pixel);
  problem.setup = setup;
  problem.medium = {Volume<double>(setup.shape, kappa), Volume<double>(setup.shape, mu)};
  problem.patterns = 2;
  problem.irradiance = patches(face_shape(setup.shape, setup.lit_face), per_pixel);
  ForwardOptions options;
  options.precision = Precision::double_precision;
  options.solve = {1e-10, 500};
  Progress silent;
  const ForwardResult grid = make_forward_model("reference")->solve(problem, options, silent);
  const std::vector<double>& map = grid.exitance[static_cast<std::size_t>(seen)];
  const FaceShape fine = face_shape(setup.shape, seen);
  std::vector<double> means(modes.size(), 0.0);
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::size_t m = i / fine.cells();
    const auto at = static_cast<int>(i % fine.cells());
    const int u = at % fine.nu / per_pixel, v = at / fine.nu / per_pixel;
    means[m * coarse.cells() + static_cast<std::size_t>(v) * coarse.nu + u] +=
        map[i] / (per_pixel * per_pixel);
  }
  double error = 0.0, square = 0.0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    error += std::pow(modes[i] - means[i], 2);
    square += means[i] * means[i];
  }
  return std::sqrt(error / square);
}

struct ModesCase {
  Face lit, seen;
  Sides sides;
  SourceModel source;
};
class ModesOf : public ::testing::TestWithParam<ModesCase> {};

TEST_P(ModesOf, AHomogeneousBlockAreWhatTheGridConvergesTo) {
  const ModesCase& c = GetParam();
  GridSetup setup;
  setup.shape = c.lit == Face::y_plus ? GridShape{12, 6, 10, 0.4} : GridShape{12, 10, 6, 0.4};
  setup.lit_face = c.lit;
  setup.sides = c.sides;
  setup.source = c.source;
  const double coarse = difference(setup, c.seen, 2);
  const double fine = difference(setup, c.seen, 4);
  // What pixels do not resolve of a patch's edge is left out at the sides too.
  const bool side = axis_of(c.seen) != axis_of(c.lit);
  EXPECT_LT(fine, side ? 0.007 : 0.02) << coarse;
  EXPECT_LT(fine, (side ? 3.0 : 0.7) * coarse);
}

constexpr auto first = SourceModel::first_collision, boundary = SourceModel::boundary;
INSTANTIATE_TEST_SUITE_P(
    Faces, ModesOf,
    ::testing::Values(ModesCase{Face::z_minus, Face::z_plus, Sides::open, first},
                      ModesCase{Face::z_minus, Face::z_plus, Sides::mirror, first},
                      ModesCase{Face::z_minus, Face::z_minus, Sides::open, first},
                      ModesCase{Face::z_minus, Face::z_minus, Sides::open, boundary},
                      ModesCase{Face::z_plus, Face::x_minus, Sides::open, first},
                      ModesCase{Face::z_minus, Face::y_plus, Sides::open, first},
                      ModesCase{Face::y_plus, Face::x_plus, Sides::open, first},
                      ModesCase{Face::y_plus, Face::z_minus, Sides::open, boundary}));

}  // namespace
}  // namespace kappamu::forward
