// The hair texture: coverage by exact areas, tiling, taper, curl, lean. What light does in it is
// tested in transfer_test.cpp.
#include "forward/shells/hair_texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "core/error.h"
#include "core/random.h"
#include "forward/shells/circle_area.h"

namespace kappamu::forward::shells {

namespace {

using std::numbers::pi;

double sum(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

HairOptions few(int hairs, double radius, double curl = 0.0) {
  HairOptions options;
  options.width = 17;
  options.layers = 11;
  options.coats = {{hairs, radius, radius, 1.0, 1.0, curl}};
  return options;
}

TEST(CircleArea, PartsOfAPartitionAddUpToTheDisc) {
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const double r = 0.01 + 0.49 * uniform(key_of({i, 0}));
    const double x = uniform(key_of({i, 1})) - 0.5, y = uniform(key_of({i, 2})) - 0.5;
    const double area = disc_in_rectangle(r, -2, -2, x, y) + disc_in_rectangle(r, x, -2, 2, y) +
                        disc_in_rectangle(r, -2, y, x, 2) + disc_in_rectangle(r, x, y, 2, 2);
    EXPECT_NEAR(area, pi * r * r, 1e-14);
  }
}

TEST(CircleArea, AgreesWithMonteCarlo) {
  constexpr int points = 4000;
  for (std::uint64_t i = 0; i < 60; ++i) {
    const double r = 0.1 + 0.4 * uniform(key_of({i, 3}));
    const double x = uniform(key_of({i, 4})) - 1.0, y = uniform(key_of({i, 5})) - 1.0;
    int inside = 0;
    for (std::uint32_t p = 0; p < points; ++p) {
      const auto [u, v] = sobol_point(p, i);
      inside += std::hypot(x + u, y + v) < r;
    }
    // Scrambled nets err less than independent points, whose five standard errors bound this.
    const double area = disc_in_rectangle(r, x, y, x + 1, y + 1);
    const double error = std::sqrt(std::max(area * (1.0 - area), 1e-4) / points);
    EXPECT_NEAR(static_cast<double>(inside) / points, area, 5.0 * error) << r << " " << x;
  }
}

TEST(HairTexture, HoldsTheVolumeOfTheHairs) {
  // A cone's volume; cuts at midpoints err by 1/(4 n²) of it, n = cuts in all.
  const HairOptions options = few(1, 0.4);
  const double cone = pi * 0.16 * options.layers / 3.0;
  EXPECT_NEAR(sum(make_hair_texture(options).density), cone, cone * 0.3 / (44.0 * 44.0));
}

TEST(HairTexture, TilesWithoutASeam) {
  // Hairs that lean by a whole tile over their height end where they began.
  HairOptions options = few(40, 0.3);
  const HairTexture upright = make_hair_texture(options);
  options.lean = [&](double, double) {
    return Eigen::Vector2d(options.width / (0.5 * options.layer_height), 0.0);
  };
  const HairTexture leaning = make_hair_texture(options);
  EXPECT_NEAR(sum(leaning.density), sum(upright.density), 1e-4 * sum(upright.density));
  // No column of texels beside the border is emptier than chance has it: per column of 17 the mean
  // area is n πr²/17, and its deviation over seeds is that of Poisson's law.
  double border = 0.0, all = 0.0;
  for (std::uint64_t seed = 10; seed < 40; ++seed) {
    HairOptions many = few(60, 0.3, 1.0);
    many.seed = seed;
    const HairTexture texture = make_hair_texture(many);
    for (std::size_t i = 0; i < texture.size(); ++i) {
      const auto x = i % 17;
      all += texture.density[i];
      if (x == 0 || x == 16) border += texture.density[i];
    }
  }
  const double share = 2.0 / 17.0;
  EXPECT_NEAR(border / all, share, 5.0 * std::sqrt(share / (30.0 * 60.0)));
}

TEST(HairTexture, HairsAreTangentToTheirWay) {
  HairOptions options = few(1, 0.3);
  options.lean = [](double, double) { return Eigen::Vector2d(0.5, -0.25); };
  const HairTexture texture = make_hair_texture(options);
  const Eigen::Vector3f expected = Eigen::Vector3f(0.5F, -0.25F, 1.0F).normalized();
  int met = 0;
  for (std::size_t i = 0; i < texture.size(); ++i) {
    if (texture.density[i] == 0.0F) continue;
    EXPECT_LT((texture.tangent[i] - expected).norm(), 1e-6F);
    ++met;
  }
  EXPECT_GT(met, options.layers - 1);
}

TEST(HairTexture, CurlIsAParabola) {
  // Of one hair's centre by layer: its way from the first layer goes as the height squared.
  HairOptions options = few(1, 0.4, 2.0);
  options.width = 64;
  const HairTexture texture = make_hair_texture(options);
  const auto centre = [&](int z) -> Eigen::Vector2d {
    std::complex<double> cx, cy;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const double weight = texture.density[texture.texel(x, y, z)];
        cx += weight * std::polar(1.0, 2.0 * pi * (x + 0.5) / 64);
        cy += weight * std::polar(1.0, 2.0 * pi * (y + 0.5) / 64);
      }
    }
    return Eigen::Vector2d(std::arg(cx), std::arg(cy)) * 64 / (2.0 * pi);
  };
  const auto way = [&](int z) -> double {
    Eigen::Vector2d d = centre(z) - centre(0);
    for (int i = 0; i < 2; ++i) d[i] -= 64.0 * std::round(d[i] / 64.0);
    return d.norm();
  };
  EXPECT_GT(way(8), 2.0);
  const double squares = (8.5 * 8.5 - 0.25) / (4.5 * 4.5 - 0.25);
  EXPECT_NEAR(way(8) / way(4), squares, 0.1 * squares);
}

TEST(HairTexture, IsNeverFullerThanFullAndReportsWhatIsLost) {
  HairOptions options = few(2000, 0.5);
  const HairTexture texture = make_hair_texture(options);
  EXPECT_GT(texture.overfull, 0.1);
  EXPECT_LE(*std::max_element(texture.density.begin(), texture.density.end()), 1.0F);
  EXPECT_LT(make_hair_texture(HairOptions{}).overfull, 0.05);
}

TEST(HairTexture, RefusesWhatItCannotHold) {
  HairOptions options = few(1, 0.6);
  EXPECT_THROW(make_hair_texture(options), InputError);
  options = few(1, 0.3);
  options.coats[0].most_length = 1.1;
  EXPECT_THROW(make_hair_texture(options), InputError);
  options = few(1, 0.3);
  options.width = 0;
  EXPECT_THROW(make_hair_texture(options), InputError);
}

}  // namespace

}  // namespace kappamu::forward::shells
