// The random walk in objects against Mitsuba 3.9.1's volpath: a box of 4 x 3 x 2 mm with diffuse
// light on its top, homogeneous and of voxels. The numbers are those that
// studies/references/mitsuba_objects.py prints; it has the scenes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "core/mesh/shapes.h"
#include "forward/montecarlo/object_monte_carlo.h"
#include "tests/render/object_tools.h"

namespace kappamu::forward {
namespace {

/// Exitance of the four quarters of the bottom, [y][x], and of the side x+, [y][z].
struct Quarters {
  std::array<double, 8> mean{}, error{};
};

Quarters traced(const ObjectMedium& medium) {
  const testing::Object object(box_mesh({4.0, 3.0, 2.0}, 8));
  const std::vector<ObjectLight> lights{
      object.diffuse([&](std::size_t i) { return object.surface.normal[i].z() > 0.5; })};
  Progress silent;
  const ObjectResult result =
      make_object_model("montecarlo", ModelError::warned, {{"photons", 3e5}})
          ->solve(object.problem(medium, 1.3, lights), {}, silent);
  Quarters quarters;
  std::array<double, 8> area{};
  for (std::size_t i = 0; i < object.surface.size(); ++i) {
    const Eigen::Vector3d &at = object.surface.position[i], &normal = object.surface.normal[i];
    const bool bottom = normal.z()<-0.5, side = normal.x()> 0.5;
    if (!bottom && !side) continue;
    const std::size_t q =
        (side ? 4U : 0U) + (at.y() > 0.0 ? 2U : 0U) + ((side ? at.z() : at.x()) > 0.0 ? 1U : 0U);
    quarters.mean[q] += result.exitance[i] * object.surface.area[i];
    quarters.error[q] += std::pow(result.standard_error[i] * object.surface.area[i], 2);
    area[q] += object.surface.area[i];
  }
  for (std::size_t q = 0; q < 8; ++q) {
    quarters.mean[q] /= area[q];
    quarters.error[q] = std::sqrt(quarters.error[q]) / area[q];
  }
  return quarters;
}

void expect_alike(const Quarters& ours, const Quarters& mitsuba) {
  constexpr double sigmas = 4.0;
  // The meters and the light stand 2e-3 mm before the faces, and light passes between.
  constexpr double gaps = 2e-3;
  double chi2 = 0.0;
  for (std::size_t q = 0; q < 8; ++q) {
    const double error = std::hypot(ours.error[q], mitsuba.error[q]);
    EXPECT_NEAR(ours.mean[q], mitsuba.mean[q], sigmas * error + gaps * ours.mean[q]) << q;
    chi2 += std::pow((ours.mean[q] - mitsuba.mean[q]) / error, 2);
  }
  EXPECT_NEAR(chi2 / 8.0, 1.0, sigmas * std::sqrt(2.0 / 8.0));
}

TEST(ObjectMonteCarloMitsuba, AgreesInAHomogeneousBox) {
  const Quarters mitsuba{
      {0.110740, 0.110262, 0.109951, 0.110245, 0.097198, 0.261981, 0.097366, 0.262080},
      {0.000331, 0.000333, 0.000274, 0.000380, 0.000293, 0.000552, 0.000289, 0.000357}};
  expect_alike(traced(ObjectMedium(testing::coefficients(0.02, 2.0))), mitsuba);
}

TEST(ObjectMonteCarloMitsuba, AgreesInAVolume) {
  const GridShape shape{4, 3, 2, 1.0};
  Medium medium{Volume<double>(shape, 0.0), Volume<double>(shape, 0.0)};
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 4; ++i) {
        const double extinction = 1.0 + (3 * i + 5 * j + 7 * k) % 5;
        const double albedo = 0.90 + 0.02 * ((i + 2 * j + 3 * k) % 5);
        const auto cell = static_cast<std::size_t>((k * 3 + j) * 4 + i);
        medium.kappa[cell] = 1.0 / (3.0 * extinction);
        medium.mu[cell] = extinction * (1.0 - albedo);
      }
    }
  }
  const Eigen::Affine3d placed(Eigen::Translation3d(2.0, 1.5, 1.0));
  const Quarters mitsuba{
      {0.061437, 0.036976, 0.061236, 0.037353, 0.036237, 0.197571, 0.034307, 0.198032},
      {0.000220, 0.000158, 0.000205, 0.000136, 0.000150, 0.000315, 0.000166, 0.000366}};
  const auto volume = std::make_shared<const Medium>(std::move(medium));
  expect_alike(traced(ObjectMedium(volume, placed, Wrap::clamp)), mitsuba);
}

}  // namespace
}  // namespace kappamu::forward
