// The radiance that Monte Carlo sends to cameras: over all directions it makes the exitance that
// photons make by leaving. (Against a closed form: slab_test.cpp.)
#include <numbers>

#include "core/optics.h"
#include "tests/forward/montecarlo/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::ChiSquare;
class MonteCarloCamera : public testing::WithDevice {};

/// A structured block, a mean free path thick, lit near one corner. It is wide beside its
/// thickness: sight by way of more than one reflection at a side is left out.
struct Scene {
  explicit Scene(Sides sides) {
    setup.shape = {8, 6, 2, 0.5};
    setup.eta = 1.4;
    setup.sides = sides;
    medium = testing::homogeneous(setup.shape, 0.05, 1.0);
    for (std::size_t i = 0; i < medium.kappa.size(); i += 3) medium.kappa[i] *= 0.4;
    light = std::vector<double>(face_shape(setup.shape, setup.lit_face).cells(), 0.0);
    light[0] = light[9] = 1.0;
  }
  GridSetup setup;
  Medium medium;
  std::vector<double> light;
};

/// Every pixel of both faces, by photons that leave and by cameras in all directions.
void expect_radiance_makes_exitance(device::Context& context, const Scene& scene, double g) {
  Progress silent;
  TraceOptions options;
  options.anisotropy = g;
  options.photons = 2'000'000;
  options.seed = 7;
  const PhotonTally leaving =
      trace_photons(context, scene.setup, scene.medium, scene.light, 1, options, silent);
  options.photons = 20'000;
  const std::size_t cells = face_shape(scene.setup.shape, Face::z_plus).cells();
  std::array<std::vector<double>, 2> mean, variance;
  for (auto* sums : {&mean, &variance}) sums->fill(std::vector<double>(cells, 0.0));
  const BoundaryConstants optics = boundary_constants(scene.setup.eta);
  constexpr int cosines = 6, turns = 8;
  for (int i = 0; i < cosines * turns; ++i) {
    const double cosine = (i / turns + 0.5) / cosines,
                 turn = 2.0 * std::numbers::pi * (i + 0.3) / turns;
    const double sine = std::sqrt(1.0 - cosine * cosine), far = 1e5;
    options.seed = 100 + static_cast<std::uint64_t>(i);
    options.cameras.clear();
    for (const Face face : {Face::z_minus, Face::z_plus}) {
      options.cameras[face] = far * Eigen::Vector3d(sine * std::cos(turn), sine * std::sin(turn),
                                                    is_plus(face) ? cosine : -cosine);
    }
    const PhotonTally seen =
        trace_photons(context, scene.setup, scene.medium, scene.light, 1, options, silent);
    // M = ∫ L cosθ dω, by the midpoint rule.
    const double weight =
        radiance_per_exitance(optics, cosine) * cosine * 2.0 * std::numbers::pi / (cosines * turns);
    for (std::size_t f = 0; f < 2; ++f) {
      const auto face = static_cast<std::size_t>(f == 0 ? Face::z_minus : Face::z_plus);
      for (std::size_t k = 0; k < cells; ++k) {
        mean[f][k] += weight * seen.view[face][k];
        variance[f][k] += std::pow(weight * seen.view_error[face][k], 2);
      }
    }
  }
  for (std::size_t f = 0; f < 2; ++f) {
    SCOPED_TRACE(f == 0 ? "lit face" : "far face");
    const std::size_t first = first_pixel(scene.setup.shape, f == 0 ? Face::z_minus : Face::z_plus);
    ChiSquare pixels;
    double sum = 0.0, expected = 0.0;
    for (std::size_t k = 0; k < cells; ++k) {
      const Score& exit = leaving.exits[first + k];
      const double out = exit.mean(leaving.photons), error = exit.standard_error(leaving.photons);
      pixels.add(mean[f][k] - out, std::sqrt(variance[f][k] + error * error));
      sum += mean[f][k];
      expected += out;
    }
    EXPECT_NEAR(sum / expected, 1.0, 0.006);  // the midpoint rule: 0.2 %
    EXPECT_TRUE(pixels.holds(50.0));
  }
}

TEST_F(MonteCarloCamera, SeesWhatLeavesAnOpenBlock) {
  expect_radiance_makes_exitance(context(), Scene(Sides::open), 0.0);
}

TEST_F(MonteCarloCamera, SeesWhatLeavesBetweenMirrorsAndScattersForward) {
  expect_radiance_makes_exitance(context(), Scene(Sides::mirror), 0.6);
}

TEST_F(MonteCarloCamera, LeavesThePhotonsAsTheyAre) {
  const Scene scene(Sides::open);
  Progress silent;
  TraceOptions options;
  options.photons = 10'000;
  const PhotonTally alone =
      trace_photons(context(), scene.setup, scene.medium, scene.light, 1, options, silent);
  options.cameras[Face::z_plus] = {1.0, 2.0, 30.0};
  const PhotonTally seen =
      trace_photons(context(), scene.setup, scene.medium, scene.light, 1, options, silent);
  EXPECT_TRUE(alone.view[static_cast<std::size_t>(Face::z_plus)].empty());
  for (std::size_t i = 0; i < alone.exits.size(); ++i) {
    EXPECT_EQ(alone.exits[i].weight, seen.exits[i].weight);
  }
  EXPECT_EQ(alone.totals[0].absorbed, seen.totals[0].absorbed);
}

}  // namespace
}  // namespace kappamu::forward
