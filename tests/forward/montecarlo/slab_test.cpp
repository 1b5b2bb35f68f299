// Monte Carlo transport against published slabs and against laws that have exact solutions:
// Chandrasekhar's half-space, Beer and Lambert's beam, conservation without absorption.
#include <numbers>

#include "core/optics.h"
#include "tests/forward/montecarlo/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Slab;
using testing::trace_slab;
class MonteCarloSlab : public testing::WithDevice {};

TEST_F(MonteCarloSlab, AgreesWithVanDeHulst) {
  // van de Hulst 1980, table 35, as in Wang, Jacques, Zheng 1995 (MCML), table 1: albedo 0.9,
  // optical thickness 2, g = 0.75, matched index. T_t holds the unscattered light.
  const auto light = trace_slab(context(), {10.0, 90.0, 0.75, 0.02, 1.0}, 1'000'000);
  EXPECT_NEAR(light.reflected, 0.09739, 3.0 * light.reflected_error);
  EXPECT_LT(light.reflected_error, 0.0003);
  // The unscattered part is known exactly, which leaves the scattered one to be tested.
  EXPECT_NEAR(light.transmitted, 0.66096 - std::exp(-2.0), 3.0 * light.transmitted_error);
  EXPECT_LT(light.transmitted_error, 0.0006);
}

TEST_F(MonteCarloSlab, AgreesWithGiovanelli) {
  // Giovanelli 1955, as in Wang, Jacques, Zheng 1995, table 2: half-space, n = 1.5, albedo 0.9,
  // isotropic, collimated light: total reflectance 0.2600, the specular 4 % in it.
  const auto light = trace_slab(context(), {1.0, 9.0, 0.0, 8.0, 1.5}, 1'000'000);
  const double specular = fresnel_external(1.5, 1.0);
  const double total = specular + (1.0 - specular) * light.reflected;
  constexpr double rounding = 0.00005;
  EXPECT_NEAR(total, 0.2600, 3.0 * light.reflected_error + rounding);
  EXPECT_LT(light.reflected_error, 0.0004);
}

/// Chandrasekhar's H for isotropic scattering, 1/H(μ) = √(1−ϖ) + ϖ/2 ∫ μ' H(μ')/(μ+μ') dμ'
/// (Radiative Transfer 1960, ch. V), by iteration on the midpoint rule.
class HalfSpace {
 public:
  explicit HalfSpace(double albedo) : albedo_(albedo), h_(nodes, 1.0) {
    for (int iteration = 0; iteration < 200; ++iteration) {
      std::vector<double> next(nodes);
      for (int i = 0; i < nodes; ++i) next[i] = at(node(i));
      h_ = next;
    }
  }
  double at(double mu) const {
    double sum = 0.0;
    for (int i = 0; i < nodes; ++i) sum += node(i) * h_[i] / (mu + node(i)) / nodes;
    return 1.0 / (std::sqrt(1.0 - albedo_) + 0.5 * albedo_ * sum);
  }
  /// Reflectance for collimated light at the cosine.
  double reflected(double mu) const { return 1.0 - std::sqrt(1.0 - albedo_) * at(mu); }
  double reflected_of_diffuse() const {
    double sum = 0.0;
    for (int i = 0; i < nodes; ++i) sum += 2.0 * node(i) * reflected(node(i)) / nodes;
    return sum;
  }
  /// Radiance at the cosine over normal irradiance.
  double radiance(double mu) const {
    return albedo_ * at(mu) * at(1.0) / (4.0 * std::numbers::pi * (1.0 + mu));
  }
  /// Part of light at normal incidence that leaves at cosines above `from`.
  double reflected_above(double from) const {
    double sum = 0.0;
    for (int i = 0; i < nodes; ++i) {
      const double mu = from + (1.0 - from) * node(i);
      sum += 0.5 * albedo_ * mu * at(mu) * at(1.0) / (1.0 + mu) * (1.0 - from) / nodes;
    }
    return sum;
  }

 private:
  static constexpr int nodes = 400;
  static double node(int i) { return (i + 0.5) / nodes; }
  double albedo_;
  std::vector<double> h_;
};

TEST_F(MonteCarloSlab, SendsCamerasChandrasekharsRadiance) {
  GridSetup setup;
  setup.shape = {1, 1, 1, 100.0};  // 100 mean free paths
  setup.eta = 1.0;
  setup.sides = Sides::mirror;
  const std::vector<double> light{1.0};
  Progress silent;
  TraceOptions options;
  options.photons = 200'000;
  for (const double albedo : {0.5, 0.9}) {
    const HalfSpace exact(albedo);
    for (const double cosine : {1.0, 0.7, 0.3}) {
      SCOPED_TRACE(std::to_string(albedo) + " at cosine " + std::to_string(cosine));
      options.cameras[Face::z_minus] =
          1e7 * Eigen::Vector3d(std::sqrt(1.0 - cosine * cosine), 0.0, -cosine);
      const PhotonTally tally =
          trace_photons(context(), setup, testing::homogeneous(setup.shape, 1.0 - albedo, albedo),
                        light, 1, options, silent);
      const double per_exitance = radiance_per_exitance(boundary_constants(1.0), cosine);
      const double found = per_exitance * tally.view[4][0],
                   error = per_exitance * tally.view_error[4][0];
      EXPECT_NEAR(found, exact.radiance(cosine), 4.0 * error);
      EXPECT_LT(error, 0.004 * found);
    }
  }
}

TEST_F(MonteCarloSlab, AgreesWithChandrasekharsHalfSpace) {
  for (const double albedo : {0.5, 0.9, 0.99}) {
    SCOPED_TRACE(albedo);
    const HalfSpace exact(albedo);
    ASSERT_NEAR(exact.reflected_above(0.0), exact.reflected(1.0), 1e-5);
    // 100 mean free paths: the far face gets less than 1e-7 of the light.
    const Slab slab{1.0 - albedo, albedo, 0.0, 100.0, 1.0};
    const auto collimated = trace_slab(context(), slab, 200'000);
    EXPECT_NEAR(collimated.reflected, exact.reflected(1.0), 3.0 * collimated.reflected_error);
    const double cone = exact.reflected_above(std::cos(std::numbers::pi / 18.0));
    EXPECT_NEAR(collimated.cone, cone, 3.0 * collimated.cone_error);
    const auto diffuse = trace_slab(context(), slab, 200'000, SourceModel::boundary);
    EXPECT_NEAR(diffuse.reflected, exact.reflected_of_diffuse(), 3.0 * diffuse.reflected_error);
    EXPECT_LT(diffuse.reflected_error, 0.002);
  }
}

TEST_F(MonteCarloSlab, UnscatteredLightIsBeerAndLambertsBetweenTwoFaces) {
  // (1−R)e^(−τ) of what reaches a face leaves by it, the rest goes round: in all
  // (1−R)e^(−τ)/(1−R e^(−τ)).
  constexpr double optical_thickness = 1.5;
  constexpr std::uint64_t photons = 400'000;
  for (const double eta : {1.0, 1.3, 2.4}) {
    for (const double albedo : {0.0, 0.6}) {
      SCOPED_TRACE(std::to_string(eta) + ", albedo " + std::to_string(albedo));
      const auto light = trace_slab(
          context(), {(1.0 - albedo) * 3.0, albedo * 3.0, 0.4, optical_thickness / 3.0, eta},
          photons);
      const double R = fresnel_internal(eta, 1.0), e = std::exp(-optical_thickness);
      const double expected = (1.0 - R) * e / (1.0 - R * e);
      const double error = std::sqrt(expected * (1.0 - expected) / photons);
      EXPECT_NEAR(light.unscattered, expected, 3.0 * error);
      if (albedo == 0.0) {
        EXPECT_EQ(light.reflected + light.transmitted, 0.0);
        EXPECT_DOUBLE_EQ(light.absorbed + light.unscattered, 1.0);
      }
    }
  }
}

TEST_F(MonteCarloSlab, LosesNothingWithoutAbsorption) {
  const auto light = trace_slab(context(), {0.0, 5.0, 0.5, 1.0, 1.5}, 50'000);
  EXPECT_EQ(light.absorbed, 0.0);
  EXPECT_DOUBLE_EQ(light.reflected + light.transmitted + light.unscattered, 1.0);
}

TEST_F(MonteCarloSlab, IsSimilarUnderEqualReducedScattering) {
  // σs(1−g) decides where light has been scattered often: ten transport mean free paths.
  const auto isotropic = trace_slab(context(), {0.01, 2.0, 0.0, 5.0, 1.3}, 60'000);
  const auto forward = trace_slab(context(), {0.01, 10.0, 0.8, 5.0, 1.3}, 60'000);
  constexpr double similarity_error = 0.01;
  const double noise = std::hypot(isotropic.transmitted_error, forward.transmitted_error);
  EXPECT_NEAR(forward.transmitted, isotropic.transmitted,
              3.0 * noise + similarity_error * isotropic.transmitted);
  // Not where it was scattered but a few times: a thin slab tells g apart.
  const auto thin = trace_slab(context(), {0.01, 2.0, 0.0, 0.25, 1.3}, 60'000);
  const auto thin_forward = trace_slab(context(), {0.01, 10.0, 0.8, 0.25, 1.3}, 60'000);
  EXPECT_GT(std::abs(thin.reflected - thin_forward.reflected), 10.0 * thin.reflected_error);
}

}  // namespace
}  // namespace kappamu::forward
