// Light in a hair texture: harmonics, their rotation, symmetry of transfer, transmittance by
// closed forms, reflectance.
#include "forward/shells/transfer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "forward/shells/reflectance.h"

namespace kappamu::forward::shells {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

Vector3d random_direction(std::uint64_t i) {
  const double z = 2.0 * uniform(key_of({i, 0})) - 1.0, a = 2.0 * pi * uniform(key_of({i, 1}));
  const double s = std::sqrt(1.0 - z * z);
  return {s * std::cos(a), s * std::sin(a), z};
}

HairTexture small_texture(std::uint64_t seed) {
  HairOptions options;
  options.width = 12;
  options.layers = 7;
  options.seed = seed;
  options.coats = {{300, 0.1, 0.2, 0.3, 1.0, 1.0}};
  options.lean = [](double, double) { return Eigen::Vector2d(0.4, 0.1); };
  return make_hair_texture(options);
}

/// The texture moved by a symmetry of the square: texel centres p go to m·p.
HairTexture moved(const HairTexture& texture, const Matrix3d& m) {
  HairTexture made = texture;
  const Vector3d middle(0.5 * texture.width, 0.5 * texture.width, 0.0);
  for (std::size_t i = 0; i < texture.size(); ++i) {
    const Vector3d to = m * (centre_of(texture, i) - middle) + middle;
    made.density[made.texel(static_cast<int>(to.x()), static_cast<int>(to.y()),
                            static_cast<int>(to.z() / texture.layer_height))] = texture.density[i];
  }
  return made;
}

TEST(Harmonics, AreOrthonormal) {
  // Gauss in z, even in the angle: exact for products of bands up to 5.
  constexpr int bands = most_bands, n = 12;
  const std::array<double, 6> node{0.1252334085114689, 0.3678314989981802, 0.5873179542866175,
                                   0.7699026741943047, 0.9041172563704749, 0.9815606342467192};
  const std::array<double, 6> weight{0.2491470458134028, 0.2334925365383548, 0.2031674267230659,
                                     0.1600783285433462, 0.1069393259953184, 0.0471753363865118};
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(harmonics_in(bands), harmonics_in(bands));
  for (std::size_t i = 0; i < node.size(); ++i) {
    for (const double z : {node[i], -node[i]}) {
      for (int a = 0; a < n; ++a) {
        const double angle = 2.0 * pi * (a + 0.3) / n, s = std::sqrt(1.0 - z * z);
        const Eigen::VectorXd y = harmonics(bands, {s * std::cos(angle), s * std::sin(angle), z});
        gram += weight[i] * 2.0 * pi / n * y * y.transpose();
      }
    }
  }
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).norm(), 1e-12);
}

TEST(Harmonics, TurnWithTheFunction) {
  for (int bands = 1; bands <= most_bands; ++bands) {
    const Turner turner(bands);
    for (std::uint64_t i = 0; i < 20; ++i) {
      const Matrix3d turn =
          Eigen::AngleAxisd(6.0 * uniform(key_of({i, 7})), random_direction(i)).toRotationMatrix();
      const Vector3d d = random_direction(i + 100);
      const Eigen::VectorXd turned = turner.turned(harmonics(bands, d), turn);
      EXPECT_LT((turned - harmonics(bands, turn * d)).norm(), 1e-11) << bands;
    }
  }
}

TEST(EvenDirections, IntegrateHarmonicsToZero) {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(25);
  const auto directions = even_directions(1024);
  for (const Vector3d& d : directions) mean += harmonics(5, d) / 1024.0;
  EXPECT_NEAR(mean[0], std::sqrt(0.25 / pi), 1e-12);
  EXPECT_LT(mean.tail(24).cwiseAbs().maxCoeff(), 2e-3);
}

TEST(Transmittance, OfAnEvenVolumeIsBeersLaw) {
  HairTexture texture;
  texture.width = 5;
  texture.layers = 4;
  texture.layer_height = 1.5;
  texture.density.assign(100, 0.25F);
  for (std::uint64_t i = 0; i < 100; ++i) {
    Vector3d d = random_direction(i);
    d.z() = std::abs(d.z());
    const Vector3d from(5.0 * uniform(key_of({i, 2})), 1.3, 6.0 * uniform(key_of({i, 3})));
    const double expected = std::exp(-0.7 * 0.25 * (6.0 - from.z()) / d.z());
    // Below e⁻¹⁴ nothing is left.
    EXPECT_NEAR(transmittance(texture, 0.7, from, d), expected < std::exp(-14.0) ? 0.0 : expected,
                1e-9);
    EXPECT_EQ(transmittance(texture, 0.7, from, Vector3d(d.x(), d.y(), -d.z())), 0.0);
  }
}

TEST(Transfer, IsSymmetricUnderTurnsAndMirrors) {
  const HairTexture texture = small_texture(77);
  Matrix3d quarter, mirror_x, mirror_y;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  mirror_x = Vector3d(-1, 1, 1).asDiagonal();
  mirror_y = Vector3d(1, -1, 1).asDiagonal();
  Progress progress;
  const TransferOptions options{5, 200, 1.3};
  const Transfer still = make_transfer(texture, options, progress);
  const Vector3d light = Vector3d(0.5, 0.3, 0.6).normalized();
  double largest = 0.0;
  for (const Matrix3d& m : {quarter, mirror_x, mirror_y, Matrix3d(quarter * mirror_x)}) {
    const HairTexture turned = moved(texture, m);
    const Transfer other = make_transfer(turned, options, progress);
    const Eigen::VectorXd here = harmonics(5, light), there = harmonics(5, m * light);
    const Vector3d middle(6, 6, 0);
    double seen = 0.0;
    for (std::size_t i = 0; i < texture.size(); ++i) {
      const Vector3d to = m * (centre_of(texture, i) - middle) + middle;
      const std::size_t j = turned.texel(static_cast<int>(to.x()), static_cast<int>(to.y()),
                                         static_cast<int>(to.z()));
      const double one = still.lit(i, here)[0];
      EXPECT_NEAR(other.lit(j, there)[0], one, 1e-6);
      seen += std::abs(one);
      largest = std::max(largest, std::abs(other.lit(j, there)[0] - one));
    }
    EXPECT_GT(seen, 1.0);
  }
  RecordProperty("largest", std::to_string(largest));
}

TEST(Transfer, OfTheWholeSkyIsTheMeanTransmittance) {
  // Light of radiance one: fluence ∫T. A net of other directions knows it to a percent.
  const HairTexture texture = small_texture(5);
  Progress progress;
  const Transfer transfer = make_transfer(texture, {1, 1024, 0.0}, progress);
  Eigen::MatrixXd even(1, 1);
  even << std::sqrt(4.0 * pi);
  double lit = 0.0, truth = 0.0;
  for (std::size_t i = 0; i < texture.size(); i += 7) {
    if (texture.density[i] == 0.0F) continue;
    lit += transfer.lit(i, even)[0];
    for (std::uint32_t s = 0; s < 1024; ++s) {
      const auto [u, v] = sobol_point(s, i);
      const double z = 2.0 * u - 1.0, across = std::sqrt(1.0 - z * z), a = 2.0 * pi * v;
      truth += 4.0 * pi / 1024 *
               transmittance(texture, transfer.r, centre_of(texture, i),
                             {across * std::cos(a), across * std::sin(a), z});
    }
  }
  EXPECT_NEAR(lit, truth, 0.01 * truth);
}

TEST(Transfer, RefusesWhatItCannotDo) {
  Progress progress;
  EXPECT_THROW(make_transfer(small_texture(1), {7, 100, 0.0}, progress), InputError);
  EXPECT_THROW(make_transfer(small_texture(1), {5, 4, 0.0}, progress), InputError);
  EXPECT_THROW(make_transfer(small_texture(1), {5, 64, -1.0}, progress), InputError);
}

TEST(HairReflectance, SendsAllEvenLightOn) {
  for (const HairModel model : {HairModel::even, HairModel::kajiya_kay, HairModel::marschner}) {
    const HairReflectance reflectance(model, 0.6);
    for (std::uint64_t i = 0; i < 6; ++i) {
      const Vector3d tangent = random_direction(i), eye = random_direction(i + 50);
      double sum = 0.0, squares = 0.0;
      constexpr int points = 60'000;
      for (std::uint32_t s = 0; s < points; ++s) {
        const auto [u, v] = sobol_point(s, 3 + i);
        const double z = 2.0 * u - 1.0, a = 2.0 * pi * v, across = std::sqrt(1.0 - z * z);
        const double p =
            4.0 * pi *
            reflectance.towards(tangent, {across * std::cos(a), across * std::sin(a), z}, eye,
                                Eigen::Array3d::Ones())[1];
        sum += p;
        squares += p * p;
      }
      const double mean = sum / points, error = std::sqrt(squares) / points;
      EXPECT_NEAR(mean, 1.0, 4.0 * error + 0.005) << i;  // 0.005: the table's step
    }
  }
}

TEST(HairReflectance, IsTheSameTurnedAndDarkerWithColour) {
  const HairReflectance reflectance(HairModel::marschner, 0.6);
  const Eigen::Array3d colour(0.9, 0.5, 0.2);
  for (std::uint64_t i = 0; i < 30; ++i) {
    const Vector3d t = random_direction(i), l = random_direction(i + 40),
                   v = random_direction(i + 80);
    const Matrix3d turn = Eigen::AngleAxisd(1.0 + i, random_direction(i + 7)).toRotationMatrix();
    const Eigen::Array3d here = reflectance.towards(t, l, v, colour);
    EXPECT_LT((here - reflectance.towards(turn * t, turn * l, turn * v, colour)).abs().maxCoeff(),
              1e-9 * (1.0 + here.maxCoeff()));
    EXPECT_GE(here[0], here[1]);
    EXPECT_GE(here[1], here[2]);
  }
}

}  // namespace

}  // namespace kappamu::forward::shells
