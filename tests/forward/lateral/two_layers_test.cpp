// Two layers of lateral light, against Monte Carlo through the same two layers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/optics.h"
#include "forward/forward_model.h"
#include "forward/lateral/lateral_reflectance.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

constexpr double layers_index = 1.4, layers_g = 0.8;

/// Reflectance by Monte Carlo (forward/montecarlo) and its standard error: a block with mirrors for
/// sides, two sinusoids' periods wide, so deep that its far side is not felt.
struct Walked {
  double reflectance = 0.0, error = 0.0;
};
Walked walked(double frequency, const LateralLayer& upper, const LateralLayer& lower,
              double thickness, std::uint64_t photons) {
  const double width = frequency > 0.0 ? 2.0 / frequency : 4.0;  // [mm]
  constexpr int columns = 32;
  const double voxel = width / columns;
  const int above = std::max(1, static_cast<int>(std::lround(thickness / voxel)));
  const int depth = above + static_cast<int>(std::ceil(25.0 / (lower.musp * voxel)));
  ForwardProblem problem;
  problem.setup.shape = {columns, 2, depth, voxel};
  problem.setup.eta = layers_index;
  problem.setup.lit_face = Face::z_minus;
  problem.setup.sides = Sides::mirror;
  problem.medium = {Volume<double>(problem.setup.shape), Volume<double>(problem.setup.shape)};
  // Voxels are cubes: a layer of another thickness than a whole number of them is scaled, which
  // leaves its optical depths alone.
  const double stretched = thickness / (above * voxel);
  for (int z = 0; z < depth; ++z) {
    const LateralLayer& of = z < above ? upper : lower;
    const double scale = z < above ? stretched : 1.0;
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < columns; ++x) {
        problem.medium.mu(x, y, z) = scale * of.mua;
        problem.medium.kappa(x, y, z) = 1.0 / (3.0 * scale * (of.mua + of.musp));
      }
    }
  }
  const auto wave = [&](int x) {  // mean over the pixel
    const double half = std::numbers::pi * frequency * voxel;
    const double sinc = half > 0.0 ? std::sin(half) / half : 1.0;
    return sinc * std::cos(2.0 * std::numbers::pi * frequency * voxel * (x + 0.5));
  };
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < columns; ++x) {
      problem.irradiance.push_back(frequency > 0.0 ? 1.0 + wave(x) : 1.0);
    }
  }
  ForwardOptions options;
  options.photons = photons;
  options.anisotropy = layers_g;
  options.device = "auto";
  Progress quiet;
  const ForwardResult result = make_forward_model("montecarlo")->solve(problem, options, quiet);
  const auto& out = result.exitance[static_cast<std::size_t>(Face::z_minus)];
  const auto& error = result.standard_error[static_cast<std::size_t>(Face::z_minus)];
  double sum = 0.0, norm = 0.0, variance = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double weight = frequency > 0.0 ? wave(static_cast<int>(i) % columns) : 1.0;
    sum += weight * out[i];
    norm += weight * weight;
    variance += weight * weight * error[i] * error[i];
  }
  const double entered = boundary_constants(layers_index).normal_transmittance;
  return {sum / (norm * entered), std::sqrt(variance) / (norm * entered)};
}

TEST(TwoLayers, AreExactWhereOneOfThemDecides) {
  const LateralReflectance half({layers_index, layers_g, {}});
  for (const double f : {0.0, 0.1, 0.3}) {
    const double alone = half(f, 0.02, 1.0).reflectance;
    LateralMedium medium{layers_index, layers_g, {}};
    medium.cover = LateralCover{{0.02, 1.0}, 0.7};
    EXPECT_NEAR(LateralReflectance(medium)(f, 0.02, 1.0).reflectance / alone, 1.0, 1e-9) << "equal";
    medium.cover = LateralCover{{0.2, 2.0}, 1e-7};
    EXPECT_NEAR(LateralReflectance(medium)(f, 0.02, 1.0).reflectance / alone, 1.0, 1e-5) << "thin";
    LateralMedium thick{layers_index, layers_g, 100.0};
    thick.base = LateralLayer{0.2, 2.0};
    EXPECT_NEAR(LateralReflectance(thick)(f, 0.02, 1.0).reflectance / alone, 1.0, 1e-5) << "thick";
  }
}

TEST(TwoLayers, CoverAndBaseAreTheSameTwoLayers) {
  LateralMedium cover{layers_index, layers_g, {}};
  cover.cover = LateralCover{{0.1, 1.5}, 0.5};
  LateralMedium base{layers_index, layers_g, 0.5};
  base.base = LateralLayer{0.02, 1.0};
  for (const double f : {0.0, 0.2}) {
    EXPECT_DOUBLE_EQ(LateralReflectance(cover)(f, 0.02, 1.0).reflectance,
                     LateralReflectance(base)(f, 0.1, 1.5).reflectance);
  }
}

TEST(TwoLayers, RefuseWhatIsNoTwoLayers) {
  LateralMedium medium{layers_index, layers_g, 1.0};
  medium.cover = LateralCover{{0.1, 1.5}, 0.5};
  EXPECT_NE(sentence_of([&] { LateralReflectance{medium}; }).find("over a half-space"),
            std::string::npos);
  LateralMedium base{layers_index, layers_g, {}};
  base.base = LateralLayer{0.02, 1.0};
  EXPECT_NE(sentence_of([&] { LateralReflectance{base}; }).find("needs its thickness"),
            std::string::npos);
}

/// Skin-like layers: a thin dark one over a bright one, a bright one over a dark one.
TEST(MonteCarloTwoLayers, AgreeWithinTheStatedError) {
  struct Case {
    LateralLayer upper, lower;
    double thickness;
  };
  constexpr std::uint64_t photons = 60000;
  for (const Case& c : {Case{{0.3, 2.0}, {0.02, 1.5}, 0.1}, Case{{0.01, 1.0}, {0.1, 2.0}, 1.0},
                        Case{{0.05, 0.7}, {0.05, 2.0}, 0.5}}) {
    LateralMedium medium{layers_index, layers_g, {}};
    medium.cover = LateralCover{c.upper, c.thickness};
    const LateralReflectance model(medium);
    for (const double f : {0.0, 0.25}) {
      const Walked mc = walked(f, c.upper, c.lower, c.thickness, photons);
      const double ours = model(f, c.lower.mua, c.lower.musp).reflectance;
      const double stated = model.relative_error(f, c.lower.mua, c.lower.musp);
      const double noise = mc.error / mc.reflectance;
      EXPECT_LT(std::abs(ours / mc.reflectance - 1.0), 2.0 * std::hypot(stated, noise))
          << "upper " << c.upper.mua << " " << c.upper.musp << " thickness " << c.thickness << " f "
          << f << ": " << mc.reflectance << " " << ours;
    }
  }
}

}  // namespace
}  // namespace kappamu::forward
