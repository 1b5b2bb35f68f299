// The fast sum against the direct one: stated accuracy, linear memory.
#include "forward/boundary_integral/summation/fast_sum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kappamu::forward::boundary_integral {
namespace {

/// Charges and dipoles on a sphere, a quarter of them on one a hundred times smaller.
SumSources cloud(int count) {
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  SumSources sources;
  for (int k = 0; k < count; ++k) {
    Eigen::Vector3d p(normal(generator), normal(generator), normal(generator));
    p.normalize();
    if (k % 4 == 0) p = Eigen::Vector3d(0.3, 0.5, 0.7) + 0.01 * p;
    sources.centre.push_back(p);
    sources.charge.push_back(1.0 + normal(generator));
    sources.dipole.push_back(0.05 * Eigen::Vector3d(normal(generator), normal(generator), 1.0));
  }
  sources.at = sources.centre;
  return sources;
}

Eigen::VectorXd direct(const SumSources& sources, const Eigen::VectorXd& strength, double decay) {
  const auto count = static_cast<int>(sources.at.size());
  Eigen::VectorXd value = Eigen::VectorXd::Zero(count);
  for (int t = 0; t < count; ++t) {
    for (int s = 0; s < count; ++s) {
      if (s == t) continue;
      const auto from = static_cast<std::size_t>(s);
      const Eigen::Vector3d d = sources.at[static_cast<std::size_t>(t)] - sources.at[from];
      const double r = d.norm(), g = std::exp(-decay * r) / (4.0 * M_PI * r);
      value[t] +=
          strength[s] * g *
          (sources.charge[from] + sources.dipole[from].dot(d) * (1.0 + decay * r) / (r * r));
    }
  }
  return value;
}

TEST(FastSum, IsAsAccurateAsStated) {
  constexpr int count = 3000;
  const SumSources sources = cloud(count);
  const SumElements targets = sources;
  Eigen::VectorXd strength(count);
  for (int k = 0; k < count; ++k) strength[k] = std::sin(0.37 * k) + 0.5;
  for (const double decay : {0.0, 1.0, 10.0, 100.0}) {
    const Eigen::VectorXd exact = direct(sources, strength, decay);
    for (const double accuracy : {1e-4, 1e-5, 1e-6}) {
      const FastSum sum(sources, targets, nullptr,
                        {.decay = decay, .order = sum_order(accuracy), .leaf = 40});
      EXPECT_LE((sum(strength) - exact).norm(), accuracy * exact.norm())
          << "decay " << decay << ", accuracy " << accuracy;
    }
  }
}

TEST(FastSum, KeptMatricesChangeNothing) {
  const SumSources sources = cloud(1000);
  const SumElements targets = sources;
  const Eigen::VectorXd strength = Eigen::VectorXd::Ones(1000);
  const auto value = [&](FastSum::Keep keep) {
    return FastSum(sources, targets, nullptr,
                   {.decay = 0.5, .order = 4, .leaf = 40, .keep = keep})(strength);
  };
  EXPECT_EQ(value(FastSum::Keep::matrices), value(FastSum::Keep::nothing));
}

TEST(FastSum, MemoryIsLinear) {
  const auto bytes_per_element = [](int count) {
    const SumSources sources = cloud(count);
    const SumElements targets = sources;
    const FastSum sum(sources, targets, nullptr, {.decay = 0.5, .order = 4, .leaf = 40});
    return static_cast<double>(sum.bytes()) / count;
  };
  // Small clouds have fewer boxes that touch; a dense matrix would be 8 times larger.
  EXPECT_LE(bytes_per_element(24'000) / bytes_per_element(3'000), 1.5);
}

}  // namespace
}  // namespace kappamu::forward::boundary_integral
