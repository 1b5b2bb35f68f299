// Lit pixels under even light and sinusoids: transport's table where light falls, and the fit of a
// homogeneous block that uses them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "core/optics.h"
#include "core/random.h"
#include "forward/lateral/lateral_reflectance.h"
#include "inverse/fit/fit_uncertainty.h"
#include "inverse/problem/lit_face.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

using testing::HasSubstr;

constexpr double index = 1.4, mua = 0.05, musp = 2.0;
constexpr double kappa = 1.0 / (3.0 * (mua + musp));
constexpr int periods = 4;                  // on 20 mm: 0.2 /mm
constexpr GridShape thick{40, 8, 30, 0.5};  // 15 mm: the far face is not felt

/// A block between mirrors, whose cosines the face's sinusoids are, seen where it is lit: even
/// light, then three phases; values by the table alone, with deviations of 0.2 %.
SurfaceMeasurements by_table(bool sharp = false) {
  SurfaceMeasurements m;
  m.grid = thick;
  m.eta = index;
  m.seen_face = Face::z_minus;
  m.sides = Sides::mirror;
  m.channels = {"grey"};
  const forward::LateralReflectance table({index, lit_anisotropy});
  const double enters = boundary_constants(index).normal_transmittance;
  const double frequency = periods / (thick.nx * thick.voxel_mm);
  const double even = table(0.0, mua, musp).reflectance;
  const double wave = table(frequency, mua, musp).reflectance;
  const FaceShape face = m.lit_shape();
  for (const double amplitude : {0.0, 0.9, -0.9, 0.45}) {
    ++m.patterns;
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        double light = amplitude * std::cos(2.0 * std::numbers::pi * periods * (u + 0.5) / face.nu);
        if (sharp) light = light > 0.0 ? 1.0 : -1.0;
        const double value = 0.5 * enters * (even + wave * light);
        m.irradiance.push_back(static_cast<float>(0.5 * (1.0 + light)));
        m.value.push_back(static_cast<float>(value));
        m.variance.push_back(static_cast<float>(std::pow(2e-3 * value, 2)));
      }
    }
  }
  m.mask.assign(m.value.size(), 0);
  m.lit.assign(m.value.size(), 1);
  return m;
}

TEST(LitFace, AnswersAsTheTableBetweenMirrors) {
  const SurfaceMeasurements m = with_lit_pixels(by_table()).measurements;
  const Problem problem = make_problem(m, 0, forward::Convention::physical, {});
  const std::vector<double> exitance = LitFace(problem).exitance(kappa, mua);
  ASSERT_EQ(exitance.size(), m.value.size());
  constexpr double interpolation = 1e-3;
  for (std::size_t i = 0; i < exitance.size(); ++i) {
    ASSERT_NEAR(exitance[i] / m.value[i], 1.0, interpolation) << i;
  }
}

TEST(LitFace, FitFindsTheCoefficientsThatDiffusionMisses) {
  FitOptions options;
  options.path.model = Model::homogeneous;
  const SurfaceMeasurements lit = with_lit_pixels(by_table()).measurements;
  const ChannelFit found = cases::fit(lit, options);
  constexpr double within = 0.01;
  EXPECT_NEAR(std::log(found.medium.kappa[0] / kappa), 0.0, within);
  EXPECT_NEAR(std::log(found.medium.mu[0] / mua), 0.0, within);
  // The deviations have the table's error and that of the anisotropy.
  const Uncertainty stated = estimate_model_uncertainty(found, lit, 0, options);
  EXPECT_THAT(stated.report.sentence, HasSubstr("the unknown anisotropy (g 0.9 within 0.05)"));
  EXPECT_GT(stated.log_mu_std[0], 5e-3);
  EXPECT_LT(stated.log_mu_std[0], 0.2);
  // What was measured is predicted, under the same light as validation too.
  const std::vector<float> predicted = predict(found.medium, lit, {});
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    ASSERT_NEAR(predicted[i] / lit.value[i], 1.0, 5e-3) << i;
  }
  // The same pixels as if diffusion described them.
  SurfaceMeasurements taken = lit;
  taken.lit.clear();
  const ChannelFit diffusion = cases::fit(taken, options);
  EXPECT_GT(std::abs(std::log(diffusion.medium.kappa[0] / kappa)) +
                std::abs(std::log(diffusion.medium.mu[0] / mua)),
            3.0 * within);
}

/// The noise of a simulation's photons, which no variance states: weights by the values themselves
/// would follow the dark ones, and μ came out 20 % too high.
TEST(LitFace, NoiseThatNobodyStatedIsMeasuredAndBiasesNothing) {
  FitOptions options;
  options.path.model = Model::homogeneous;
  for (const std::uint64_t seed : {1, 2, 3}) {
    SurfaceMeasurements m = by_table();
    constexpr double relative = 0.1;  // of the mean value
    double mean = 0.0;
    for (const float value : m.value) mean += value / static_cast<double>(m.value.size());
    for (std::size_t i = 0; i < m.value.size(); ++i) {
      const double white = std::sqrt(12.0) * (uniform(key_of({seed, i})) - 0.5);
      m.value[i] *= static_cast<float>(1.0 + relative * white * std::sqrt(mean / m.value[i]));
      m.variance[i] = static_cast<float>(std::pow(2e-3 * m.value[i], 2)) + 1e-12F;
    }
    const LitPixelUse use = with_lit_pixels(m);
    EXPECT_NEAR(use.noise / relative, 1.0, 0.5) << seed;
    EXPECT_LT(use.stated, 0.1 * relative);
    const ChannelFit found = cases::fit(use.measurements, options);
    EXPECT_LT(found.report.chi2_per_value, 1.8) << seed;
    const Uncertainty stated = estimate_model_uncertainty(found, use.measurements, 0, options);
    EXPECT_LT(std::abs(std::log(found.medium.kappa[0] / kappa)), 3.0 * stated.log_kappa_std[0]);
    EXPECT_LT(std::abs(std::log(found.medium.mu[0] / mua)), 3.0 * stated.log_mu_std[0]);
    constexpr double within = 0.05;  // chance alone leaves 1.4 and 1.5 %
    EXPECT_NEAR(std::log(found.medium.kappa[0] / kappa), 0.0, within) << seed;
    EXPECT_NEAR(std::log(found.medium.mu[0] / mua), 0.0, within) << seed;
  }
}

TEST(LitFace, IsRefusedWhereTheTableDoesNotHold) {
  const auto sentence = [](const SurfaceMeasurements& m) {
    try {
      with_lit_pixels(m);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(sentence(by_table()), "");
  EXPECT_THAT(sentence(by_table(true)), HasSubstr("no pattern's light varies slowly enough"));
  SurfaceMeasurements m = by_table();
  m.eta = 1.3;
  EXPECT_THAT(sentence(m), HasSubstr("eta from 1.33 to 1.5, not for 1.3"));
  m = by_table();
  m.light = Light::diffuse;
  EXPECT_THAT(sentence(m), HasSubstr("diffuse light"));
  m = by_table();
  m.lit.clear();
  EXPECT_THAT(sentence(m), HasSubstr("no pixel was measured where light falls"));
}

}  // namespace
}  // namespace kappamu::inverse
