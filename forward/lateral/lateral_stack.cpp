#include "forward/lateral/lateral_stack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kappamu::forward {

namespace {

// Cubic between nodes 0.3 apart in logarithms: within 2e-4 of the light (two_layers_test.cpp).
constexpr double log_step = 0.3;
// Frequencies that pictures have are multiples of it; on tilted ones light is linear in between.
constexpr double frequency_step = 0.0025;
constexpr double darkest = 1e-30;

/// Weights of the nodes −1, 0, 1, 2 at t in [0, 1], and their derivatives (Lagrange).
struct CubicWeights {
  std::array<double, 4> value, derivative;
  explicit CubicWeights(double t)
      : value{-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
              -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0},
        derivative{-(3.0 * t * t - 6.0 * t + 2.0) / 6.0, (3.0 * t * t - 4.0 * t - 1.0) / 2.0,
                   -(3.0 * t * t - 2.0 * t - 2.0) / 2.0, (3.0 * t * t - 1.0) / 6.0} {}
};

}  // namespace

LateralStack::LateralStack(const LateralMedium& medium) : medium_(medium) {}

LateralStack::Node LateralStack::node(int frequency, int mua, int musp) const {
  constexpr int offset = 1 << 15;
  const std::uint64_t key = static_cast<std::uint64_t>(frequency) << 32 |
                            static_cast<std::uint64_t>(mua + offset) << 16 |
                            static_cast<std::uint64_t>(musp + offset);
  {
    const std::shared_lock guard(lock_);
    if (const auto found = nodes_.find(key); found != nodes_.end()) return found->second;
  }
  constexpr double endless = std::numeric_limits<double>::infinity();
  const double a = std::exp(log_step * mua), s = std::exp(log_step * musp);
  std::vector<TransportLayer> layers;
  if (medium_.cover) {
    const LateralCover& cover = *medium_.cover;
    layers = {{cover.mua, cover.musp, cover.thickness_mm}, {a, s, endless}};
  } else {
    layers = {{a, s, medium_.thickness_mm.value_or(endless)}};
    if (medium_.base) layers.push_back({medium_.base->mua, medium_.base->musp, endless});
  }
  std::call_once(
      made_, [&] { transport_.emplace(medium_.index, medium_.anisotropy, medium_.slide_index); });
  const LayeredLight light = (*transport_)(layers, frequency_step * frequency);
  const Node made{std::log(std::max(light.reflectance, darkest)),
                  std::log(std::max(light.transmittance, darkest))};
  const std::unique_lock guard(lock_);
  nodes_.emplace(key, made);
  return made;
}

LateralValue LateralStack::at(double frequency, double mua, double musp, double Node::*of) const {
  const double x = std::log(mua) / log_step, y = std::log(musp) / log_step;
  const double f = frequency / frequency_step;
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const CubicWeights along_mua(x - i), along_musp(y - j);
  constexpr double rounding = 1e-6;
  const int below = static_cast<int>(std::floor(f + rounding));
  const double share = std::max(0.0, f - below);
  double value = 0.0, by_mua = 0.0, by_musp = 0.0;
  for (int k = 0; k <= (share > rounding ? 1 : 0); ++k) {
    const double part = share > rounding ? (k == 0 ? 1.0 - share : share) : 1.0;
    for (int p = 0; p < 4; ++p) {
      const auto a = static_cast<std::size_t>(p);
      for (int q = 0; q < 4; ++q) {
        const auto b = static_cast<std::size_t>(q);
        const double log_light = part * (node(below + k, i + p - 1, j + q - 1).*of);
        value += along_mua.value[a] * along_musp.value[b] * log_light;
        by_mua += along_mua.derivative[a] * along_musp.value[b] * log_light;
        by_musp += along_mua.value[a] * along_musp.derivative[b] * log_light;
      }
    }
  }
  const double light = std::exp(value);
  return {light, light * by_mua / (log_step * mua), light * by_musp / (log_step * musp)};
}

LateralValue LateralStack::reflectance(double frequency, double mua, double musp) const {
  return at(frequency, mua, musp, &Node::reflected);
}

LateralValue LateralStack::transmittance(double frequency, double mua, double musp) const {
  return at(frequency, mua, musp, &Node::transmitted);
}

}  // namespace kappamu::forward
