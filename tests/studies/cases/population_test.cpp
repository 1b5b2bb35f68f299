// Families of truths: figures that do not depend on the grid, with the structure they are named
// for.
#include "tests/cases/population.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kappamu::test_cases {
namespace {

constexpr GridShape shape{16, 16, 8, 0.5};

double share_of_change(const inverse::CoefficientPair& a, const inverse::CoefficientPair& b) {
  std::size_t changed = 0;
  for (std::size_t i = 0; i < a.log_kappa.size(); ++i) {
    changed += std::abs(a.log_kappa[i] - b.log_kappa[i]) > 0.3 ? 1 : 0;
  }
  return static_cast<double>(changed) / static_cast<double>(a.log_kappa.size());
}

TEST(Population, EqualSeedsGiveOneFigureAndOthersOthers) {
  for (const auto& [name, family] : family_names) {
    const auto first = make_family(shape, family, 0.5, 5);
    EXPECT_EQ(first.log_mu, make_family(shape, family, 0.5, 5).log_mu) << name;
    EXPECT_NE(first.log_mu, make_family(shape, family, 0.5, 6).log_mu) << name;
  }
}

TEST(Population, IsTheSameFigureOnAFinerGrid) {
  // Three times as fine: the middle one of three voxels lies where the coarse one does.
  const GridShape fine = shape.refined(3);
  for (const auto& [name, family] : family_names) {
    const auto coarse = make_family(shape, family, 0.5, 7);
    const auto split = make_family(fine, family, 0.5, 7);
    for (int z = 0; z < shape.nz; ++z) {
      for (int x = 0; x < shape.nx; ++x) {
        const std::size_t i = shape.index(x, 3, z), j = fine.index(3 * x + 1, 10, 3 * z + 1);
        EXPECT_NEAR(coarse.log_kappa[i], split.log_kappa[j], 1e-9) << name;
        EXPECT_NEAR(coarse.log_mu[i], split.log_mu[j], 1e-9) << name;
      }
    }
  }
}

TEST(Population, VeinsAreThinAndOfLowKappaAndHighMu) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const GridShape fine = shape.refined(3);
    TruthSpec around;
    around.seed = seed;
    around.inclusions = false;
    around.contrast = 2.0;
    const auto without = make_truth(fine, around);
    const auto with = make_family(fine, Family::veins, 0.5, seed);
    const double share = share_of_change(with, without);
    EXPECT_GT(share, 0.02) << seed;
    EXPECT_LT(share, 0.5) << seed;
    for (std::size_t i = 0; i < with.log_mu.size(); ++i) {
      EXPECT_LE(with.log_kappa[i], without.log_kappa[i] + 1e-9);
      EXPECT_GE(with.log_mu[i], without.log_mu[i] - 1e-9);
    }
  }
}

TEST(Population, LayersAreEvenAcrossTheLightButForTwoBalls) {
  const auto layers = make_family(shape, Family::layers, 0.5, 3);
  for (int z = 0; z < shape.nz; ++z) {
    std::vector<double> slice;
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) slice.push_back(layers.log_kappa[shape.index(x, y, z)]);
    }
    std::sort(slice.begin(), slice.end());
    EXPECT_EQ(slice[slice.size() / 2], slice[slice.size() * 2 / 3]) << z;
  }
}

}  // namespace
}  // namespace kappamu::test_cases
