// The regularisers: derivatives, independence of the grid, and what tells them apart.
#include "inverse/regulariser/roughness.h"
#include "core/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "inverse/optimise/optimiser.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

using cases::Noise;

constexpr double thickness = 3.0;  // mm

CoefficientPair random_fields(const GridShape& shape, std::uint64_t seed, double height) {
  Noise noise(seed);
  CoefficientPair fields{Vector(shape.cells()), Vector(shape.cells())};
  for (double& x : fields.log_kappa) x = height * noise.normal();
  for (double& x : fields.log_mu) x = height * noise.normal();
  return fields;
}

Regulariser of(RegulariserKind kind, double slope = 2.0) {
  return {kind, slope, 3.0};
}

class RoughnessOf : public ::testing::TestWithParam<Regulariser> {};

TEST_P(RoughnessOf, TaylorRemainderIsOfOrderTwo) {
  const GridShape shape{7, 5, 3, 0.5};  // prime extents
  const CoefficientPair at = random_fields(shape, 1, 0.5);
  const CoefficientPair direction = random_fields(shape, 2, 1.0);
  const Anchor anchor{0.3, -0.2, 2.0};
  const Roughness here = roughness({shape, 2, thickness}, at, anchor, GetParam());
  double slope = 0.0;
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    slope += here.gradient.log_kappa[i] * direction.log_kappa[i] +
             here.gradient.log_mu[i] * direction.log_mu[i];
  }
  std::vector<double> remainders;
  for (const double step : {1e-2, 1e-3, 1e-4}) {
    CoefficientPair moved = at;
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      moved.log_kappa[i] += step * direction.log_kappa[i];
      moved.log_mu[i] += step * direction.log_mu[i];
    }
    remainders.push_back(
        std::abs(roughness({shape, 2, thickness}, moved, anchor, GetParam()).value - here.value -
                 step * slope));
  }
  // Huber's second derivative jumps where a slope crosses the edge's.
  constexpr double blur = 0.2;
  EXPECT_NEAR(std::log10(remainders[0] / remainders[1]), 2.0, blur);
  EXPECT_NEAR(std::log10(remainders[1] / remainders[2]), 2.0, blur);
}

INSTANTIATE_TEST_SUITE_P(EveryKind, RoughnessOf,
                         ::testing::Values(of(RegulariserKind::h1),
                                           of(RegulariserKind::huber_tv, 2.0),
                                           of(RegulariserKind::huber_tv, 0.1),
                                           of(RegulariserKind::wang2008)));

/// u = cos(πx/a) along one axis: ∫|u'|² and ∫|u'| are known.
CoefficientPair wave(const GridShape& shape) {
  CoefficientPair fields{Vector(shape.cells()), Vector(shape.cells(), 0.0)};
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    const double x = (static_cast<double>(i % static_cast<std::size_t>(shape.nx)) + 0.5) / shape.nx;
    fields.log_kappa[i] = std::cos(std::numbers::pi * x);
  }
  return fields;
}

TEST(Roughness, ConvergesToItsIntegralOnFinerGrids) {
  // Block of 4 × 2 × 1 mm. H1: ½ ∫ (π/a)² sin² dV / ℓ. TV, where δ is far below every slope:
  // δ ∫ |u'| dV / ℓ = δ · 2 · area / ℓ, δ = t/ℓ.
  const double h1 = 0.5 * std::pow(std::numbers::pi / 4.0, 2) * 0.5 * 8.0 / thickness;
  constexpr double t = 1e-3;
  const double tv = t / thickness * 2.0 * 2.0 / thickness;
  double h1_error = 0.0;
  for (const int n : {8, 16, 32}) {
    const GridShape shape{4 * n / 4, n / 2, n / 4, 4.0 / n};
    const double found = roughness({shape, 2, thickness}, wave(shape)).value;
    const double error = std::abs(found - h1);
    if (h1_error > 0.0) {
      EXPECT_LT(error, 0.3 * h1_error) << "order 2 at n = " << n;
    }
    h1_error = error;
    const double found_tv = roughness({shape, 2, thickness}, wave(shape), std::nullopt,
                                      of(RegulariserKind::huber_tv, t))
                                .value;
    // At the ends of the block the mean of the two faces' squares is half of one: order 1.
    EXPECT_NEAR(found_tv / tv, 1.0, 1.5 / n) << n;
  }
}

TEST(Roughness, HuberTvIsH1BelowTheEdgeSlope) {
  const GridShape shape{6, 5, 4, 0.5};
  const CoefficientPair fields = random_fields(shape, 3, 1.0);
  const Roughness h1 = roughness({shape, 2, thickness}, fields);
  const Roughness tv =
      roughness({shape, 2, thickness}, fields, std::nullopt, of(RegulariserKind::huber_tv, 1e6));
  constexpr double rounding = 1e-12;
  EXPECT_NEAR(tv.value / h1.value, 1.0, rounding);
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    ASSERT_NEAR(tv.gradient.log_mu[i], h1.gradient.log_mu[i], rounding * h1.value);
  }
}

TEST(Roughness, HuberTvChargesAnEdgeByItsHeightNotItsSquare) {
  const GridShape shape{32, 4, 4, 0.25};
  const auto edge = [&](double height, int width) {
    CoefficientPair fields{Vector(shape.cells()), Vector(shape.cells(), 0.0)};
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      const int x = static_cast<int>(i % 32);
      fields.log_kappa[i] = height * std::clamp((x - 16 + 0.5 * width) / width, 0.0, 1.0);
    }
    return fields;
  };
  const auto cost = [&](RegulariserKind kind, double height, int width) {
    return roughness({shape, 2, thickness}, edge(height, width), std::nullopt, of(kind, 0.1)).value;
  };
  const auto h1 = RegulariserKind::h1;
  const auto tv = RegulariserKind::huber_tv;
  EXPECT_NEAR(cost(h1, 2.0, 8) / cost(h1, 1.0, 8), 4.0, 1e-9);
  EXPECT_NEAR(cost(tv, 2.0, 8) / cost(tv, 1.0, 8), 2.0, 0.1);
  // H1 charges four times as much for the same height over two voxels' faces as over eight; total
  // variation charges the height, by at most √2 more where an edge is one face wide.
  EXPECT_GT(cost(h1, 1.0, 1), 3.5 * cost(h1, 1.0, 8));
  EXPECT_LT(cost(tv, 1.0, 1), std::sqrt(2.0) * cost(tv, 1.0, 8));
}

/// Of materials, not of coefficients: where κ has an edge, one of μ costs less.
TEST(Roughness, HuberTvChargesEdgesOfBothCoefficientsTogether) {
  const GridShape shape{32, 4, 4, 0.25};
  const auto cost = [&](double kappa, double mu) {
    CoefficientPair fields{Vector(shape.cells()), Vector(shape.cells())};
    for (std::size_t i = 0; i < shape.cells(); ++i) {
      fields.log_kappa[i] = i % 32 < 16 ? 0.0 : kappa;
      fields.log_mu[i] = i % 32 < 16 ? 0.0 : mu;
    }
    return roughness({shape, 2, thickness}, fields, std::nullopt,
                     of(RegulariserKind::huber_tv, 0.01))
        .value;
  };
  EXPECT_NEAR(cost(0.0, absorbers_vary) / cost(1.0, 0.0), 1.0, 1e-9);
  EXPECT_NEAR(cost(1.0, absorbers_vary) / cost(1.0, 0.0), std::sqrt(2.0), 0.02);
}

/// The quadratic form that stands for R touches it where it was taken and bounds it elsewhere.
TEST(Roughness, LaggedDiffusivityMajorises) {
  const GridShape shape{6, 5, 4, 0.5};
  const Anchor anchor{0.1, -0.2, 7.0};
  const CoefficientPair at = random_fields(shape, 4, 1.0);
  const auto inner = [](const CoefficientPair& a, const CoefficientPair& b) {
    return std::inner_product(a.log_kappa.begin(), a.log_kappa.end(), b.log_kappa.begin(), 0.0) +
           std::inner_product(a.log_mu.begin(), a.log_mu.end(), b.log_mu.begin(), 0.0);
  };
  for (const RegulariserKind kind : {RegulariserKind::h1, RegulariserKind::huber_tv}) {
    const Roughness here = roughness({shape, 2, thickness}, at, anchor, of(kind, 0.5));
    EXPECT_EQ(here.diffusivity.empty(), kind == RegulariserKind::h1);
    double loosest = 0.0;
    for (const double size : {0.01, 0.3, 3.0}) {
      const CoefficientPair change = random_fields(shape, 9, size);
      CoefficientPair moved = at;
      for (std::size_t i = 0; i < shape.cells(); ++i) {
        moved.log_kappa[i] += change.log_kappa[i];
        moved.log_mu[i] += change.log_mu[i];
      }
      const double there = roughness({shape, 2, thickness}, moved, anchor, of(kind, 0.5)).value;
      const double bound =
          here.value + inner(here.gradient, change) +
          0.5 * inner(change, smoothing_product({shape, 2, thickness}, anchor.length_mm,
                                                here.diffusivity, change));
      EXPECT_LE(there, bound * (1.0 + 1e-12)) << static_cast<int>(kind) << ", " << size;
      loosest = std::max(loosest, bound / there - 1.0);
    }
    EXPECT_EQ(loosest > 0.1, kind == RegulariserKind::huber_tv) << loosest;
  }
}

TEST(Roughness, WangsSmoothsKappaAlone) {
  const GridShape shape{6, 5, 4, 0.5};
  CoefficientPair fields = random_fields(shape, 4, 1.0);
  const Roughness before =
      roughness({shape, 2, thickness}, fields, Anchor{}, of(RegulariserKind::wang2008));
  for (double& x : fields.log_mu) x *= 3.0;
  const Roughness after =
      roughness({shape, 2, thickness}, fields, Anchor{}, of(RegulariserKind::wang2008));
  EXPECT_EQ(before.value, after.value);
  EXPECT_THAT(after.gradient.log_mu, ::testing::Each(0.0));
}

/// ½ ∫ (u − step)² dV + α R by L-BFGS: a problem whose minimiser the weight alone decides.
class Denoising final : public Function {
 public:
  Denoising(const GridShape& shape, double weight, const Regulariser& regulariser)
      : shape_(shape), weight_(weight), regulariser_(regulariser) {}
  double value(const Vector& z) override {
    z_ = z;
    const CoefficientPair fields{z, Vector(z.size(), 0.0)};
    roughness_ = roughness({shape_, 2, thickness}, fields, std::nullopt, regulariser_);
    const double volume = std::pow(shape_.voxel_mm, 3);
    double sum = 0.0;
    for (std::size_t i = 0; i < z.size(); ++i) sum += 0.5 * volume * std::pow(z[i] - target(i), 2);
    return sum + weight_ * roughness_.value;
  }
  Vector gradient() override {
    const double volume = std::pow(shape_.voxel_mm, 3);
    Vector g = roughness_.gradient.log_kappa;
    for (std::size_t i = 0; i < g.size(); ++i) {
      g[i] = weight_ * g[i] + volume * (z_[i] - target(i));
    }
    return g;
  }
  double amplitude(const Vector&, const Vector& direction) override {
    double largest = 0.0;
    for (const double x : direction) largest = std::max(largest, std::abs(x));
    return largest;
  }

 private:
  double target(std::size_t i) const {
    return 2 * static_cast<int>(i % static_cast<std::size_t>(shape_.nx)) < shape_.nx ? 0.0 : 1.0;
  }
  GridShape shape_;
  double weight_;
  Regulariser regulariser_;
  Vector z_;
  Roughness roughness_;
};

Vector minimiser(const GridShape& shape, const Regulariser& regulariser) {
  Denoising function(shape, 1.0, regulariser);
  OptimiserState state;
  state.z.assign(shape.cells(), 0.5);
  start(function, state);
  for (int k = 0; k < 300; ++k) {
    if (step(function, state, {}) == StepOutcome::stalled) break;
  }
  return state.z;
}

TEST(Roughness, OneWeightHasOneMinimiserOnEveryGrid) {
  for (const RegulariserKind kind : {RegulariserKind::h1, RegulariserKind::huber_tv}) {
    double last = 0.0;
    for (const int n : {8, 16}) {
      const GridShape coarse{n, 2, 2, 4.0 / n};
      const Vector on_coarse = minimiser(coarse, of(kind));
      const GridShape fine = coarse.refined(2);
      const Vector on_fine = minimiser(fine, of(kind));
      double largest = 0.0;
      for (int x = 0; x < n; ++x) {
        const double mean =
            0.5 * (on_fine[fine.index(2 * x, 0, 0)] + on_fine[fine.index(2 * x + 1, 0, 0)]);
        largest = std::max(largest, std::abs(on_coarse[coarse.index(x, 0, 0)] - mean));
      }
      // The minimiser rises by a half over 2 mm; the edge of Huber-TV is told by the voxels beside
      // it.
      const double discretisation = kind == RegulariserKind::h1 ? 0.1 : 0.2;  // per mm of h
      EXPECT_LT(largest, discretisation * coarse.voxel_mm)
          << static_cast<int>(kind) << " at n = " << n;
      if (last > 0.0 && kind == RegulariserKind::h1) {
        EXPECT_LT(largest, 0.7 * last);
      }
      last = largest;
    }
  }
}

TEST_P(RoughnessOf, AnObjectIsThatOfTheVoxelsInside) {
  const Anchor anchor{0.3, -0.2, 2.0};
  // An object that is the lower layers of its box: the regulariser of a box of those alone.
  const GridShape box{6, 5, 7, 0.5}, lower{6, 5, 4, 0.5};
  MediumSpace object{box, 2, thickness};
  for (std::size_t i = 0; i < box.cells(); ++i) {
    object.fraction.push_back(i < lower.cells() ? 1.0F : 0.0F);
  }
  const CoefficientPair fields = random_fields(box, 3, 1.0);
  const auto cut = [&](const std::vector<double>& v) {
    return std::vector<double>(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(lower.cells()));
  };
  const Roughness found = roughness(object, fields, anchor, GetParam());
  const Roughness expected = roughness(
      {lower, 2, thickness}, {cut(fields.log_kappa), cut(fields.log_mu)}, anchor, GetParam());
  EXPECT_NEAR(found.value / expected.value, 1.0, 1e-12);
  EXPECT_EQ(cut(found.gradient.log_kappa), expected.gradient.log_kappa);
  EXPECT_EQ(cut(found.gradient.log_mu), expected.gradient.log_mu);
  for (std::size_t i = lower.cells(); i < box.cells(); ++i) {
    EXPECT_EQ(found.gradient.log_kappa[i], 0.0);
    EXPECT_EQ(found.gradient.log_mu[i], 0.0);
  }
}

}  // namespace
}  // namespace kappamu::inverse
