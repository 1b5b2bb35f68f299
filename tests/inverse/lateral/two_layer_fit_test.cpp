// Both layers from several spatial frequencies: exact data, what they determine, and Monte Carlo's.
#include "inverse/lateral/two_layer_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tests/forward/lateral/walked_layers.h"

namespace kappamu::inverse {
namespace {

struct LayerPair {
  const char* name;
  LateralCoefficients upper, lower;
  double thickness;
};
/// Skin over flesh, a bright layer over a dark one, a dark one over a bright one.
constexpr std::array<LayerPair, 3> layer_pairs{{{"skin", {0.3, 2.0}, {0.02, 1.5}, 0.1},
                                                {"bright", {0.02, 1.0}, {0.1, 2.0}, 1.0},
                                                {"dark", {0.06, 1.8}, {0.015, 1.0}, 1.5}}};

PerFrequency six_frequencies() {
  PerFrequency f(6);
  f << 0.0, 0.02, 0.05, 0.1, 0.2, 0.4;
  return f;
}

Eigen::MatrixXd white(const PerFrequency& deviation) {
  return deviation.array().square().matrix().asDiagonal();
}

std::array<double, 4> logs_off(const TwoLayerFit& fit, const LayerPair& truth) {
  return {std::log(fit.upper.mua / truth.upper.mua), std::log(fit.upper.musp / truth.upper.musp),
          std::log(fit.lower.mua / truth.lower.mua), std::log(fit.lower.musp / truth.lower.musp)};
}

TEST(TwoLayerFit, ExactLightGivesTheLayersWithinWhatItTells) {
  const forward::LayeredTransport transport(1.4, 0.9);
  const PerFrequency f = six_frequencies();
  for (const LayerPair& pair : layer_pairs) {
    const std::array<forward::TransportLayer, 2> layers{
        {{pair.upper.mua, pair.upper.musp, pair.thickness},
         {pair.lower.mua, pair.lower.musp, std::numeric_limits<double>::infinity()}}};
    PerFrequency reflectance(f.size());
    for (Eigen::Index i = 0; i < f.size(); ++i) {
      reflectance[i] = transport(layers, f[i]).reflectance;
    }
    for (const double error : {1e-4, 3e-3}) {
      const TwoLayerFit fit =
          fit_two_layers(transport, pair.thickness, f, reflectance,
                         white(PerFrequency::Constant(f.size(), error)), {0.03, 1.4});
      EXPECT_TRUE(fit.converged) << pair.name;
      const std::array<double, 4> off = logs_off(fit, pair);
      for (std::size_t k = 0; k < off.size(); ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        const double stated = std::sqrt(fit.covariance(at, at));
        RecordProperty(std::string(pair.name) + std::to_string(error) + "_" + std::to_string(k),
                       std::to_string(stated));
        EXPECT_LT(std::abs(off[k]), stated) << pair.name << " " << error << " " << k;
      }
      if (error < 1e-3) {
        EXPECT_TRUE(fit.determined(1) && fit.determined(3)) << pair.name;
      }
    }
  }
}

/// Photons of seeds that nothing else draws.
TEST(MonteCarloTwoLayerFit, LayersAreWithinTheirDeviations) {
  const forward::LayeredTransport transport(test_cases::layers_index, test_cases::layers_g);
  const PerFrequency f = six_frequencies();
  constexpr std::uint64_t photons = 100000;
  double squares = 0.0;
  for (const LayerPair& pair : layer_pairs) {
    PerFrequency reflectance(f.size()), deviation(f.size());
    for (Eigen::Index i = 0; i < f.size(); ++i) {
      const test_cases::Walked mc = test_cases::walked(
          f[i], {pair.upper.mua, pair.upper.musp}, {pair.lower.mua, pair.lower.musp},
          pair.thickness, photons, 101 + static_cast<std::uint64_t>(i));
      reflectance[i] = mc.reflectance;
      deviation[i] = std::hypot(mc.error / mc.reflectance, 4e-3);
    }
    const TwoLayerFit fit =
        fit_two_layers(transport, pair.thickness, f, reflectance, white(deviation), {0.03, 1.4});
    EXPECT_TRUE(fit.converged) << pair.name;
    EXPECT_LT(fit.chi_square, 15.0) << pair.name;
    const std::array<double, 4> off = logs_off(fit, pair);
    for (std::size_t k = 0; k < off.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double stated = std::sqrt(fit.covariance(at, at));
      RecordProperty(std::string(pair.name) + std::to_string(k),
                     std::to_string(off[k]) + " of " + std::to_string(stated));
      if (pair.thickness * pair.upper.musp < thin_layer) {  // up to six deviations off: it warns
        EXPECT_LT(std::abs(off[k]), std::max(0.6, 3.0 * stated)) << pair.name << " " << k;
        continue;
      }
      EXPECT_LT(std::abs(off[k]), 3.0 * stated) << pair.name << " " << k;
      squares += off[k] * off[k] / (stated * stated) / 8.0;
    }
  }
  EXPECT_LT(squares, 2.0);
}

}  // namespace
}  // namespace kappamu::inverse
