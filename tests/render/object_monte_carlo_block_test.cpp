// The random walk in objects against the one in blocks, which knows no triangles: a box, collimated
// light on its lower face, homogeneous and of the block's own voxels.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "core/mesh/shapes.h"
#include "device/device_info.h"
#include "forward/montecarlo/monte_carlo_model.h"
#include "forward/montecarlo/object_monte_carlo.h"
#include "tests/render/object_tools.h"

namespace kappamu::forward {
namespace {

constexpr GridShape shape{6, 5, 4, 0.5};
constexpr double eta = 1.3;
constexpr std::uint64_t photons = 200'000;

Medium uneven() {
  Medium medium{Volume<double>(shape, 0.0), Volume<double>(shape, 0.0)};
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    medium.kappa[i] = 1.0 / (3.0 * (1.0 + static_cast<double>(i * 7 % 5)));
    medium.mu[i] = 0.02 * static_cast<double>(i * 3 % 4);
  }
  return medium;
}

/// Sums over faces, and their standard errors.
struct Faces {
  std::array<double, 6> power{}, error{};
  double unscattered = 0.0, absorbed = 0.0;
};

Faces in_block(const Medium& medium) {
  GridSetup setup;
  setup.shape = shape;
  setup.eta = eta;
  const std::vector<double> light(face_shape(shape, Face::z_minus).cells(), 1.0);
  ForwardOptions options;
  options.photons = photons;
  Progress silent;
  const ForwardResult result =
      make_monte_carlo_model()->solve({setup, medium, 1, light}, options, silent);
  Faces faces;
  for (std::size_t f = 0; f < 6; ++f) {
    faces.power[f] = result.balance[0].exiting[f];
    faces.error[f] = std::sqrt(faces.power[f] * result.balance[0].entering / photons);
  }
  faces.unscattered = result.balance[0].unscattered;
  faces.absorbed = result.balance[0].absorbed;
  return faces;
}

Faces in_object(const ObjectMedium& medium) {
  const Eigen::Vector3d size = shape.voxel_mm * Eigen::Vector3d(shape.nx, shape.ny, shape.nz);
  const testing::Object object(moved(box_mesh(size, 6), 0.5 * size));
  std::vector<ObjectLight> lights(1);
  // A beam on each of 16 points of every triangle of the lit face, all of the same power per area;
  // some of them on the box's edges.
  for (std::size_t t = 0; t < object.surface.size(); ++t) {
    if (object.surface.normal[t].z() > -0.5) continue;
    const auto& [a, b, c] = object.mesh.triangles[t];
    const auto corner = [&](int v) { return object.mesh.vertices[static_cast<std::size_t>(v)]; };
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        double u = (i + 0.5) / 4.0, v = (j + 0.5) / 4.0;
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        lights[0].beams.push_back(
            {static_cast<int>(t),
             corner(a) + u * (corner(b) - corner(a)) + v * (corner(c) - corner(a)),
             Eigen::Vector3d::UnitZ(), object.surface.area[t] / 16.0});
      }
    }
  }
  Progress silent;
  const ObjectResult result =
      make_object_model("montecarlo", ModelError::warned, {{"photons", double{photons}}})
          ->solve(object.problem(medium, eta, lights), {}, silent);
  Faces faces;
  for (std::size_t t = 0; t < object.surface.size(); ++t) {
    int axis = 0;
    object.surface.normal[t].cwiseAbs().maxCoeff(&axis);
    const std::size_t f =
        static_cast<std::size_t>(2 * axis) + (object.surface.normal[t][axis] > 0.0 ? 1U : 0U);
    faces.power[f] += result.exitance[t] * object.surface.area[t];
  }
  for (std::size_t f = 0; f < 6; ++f) {
    faces.error[f] = std::sqrt(faces.power[f] * result.balance[0].entering / photons);
  }
  faces.unscattered = result.balance[0].unscattered;
  faces.absorbed = result.balance[0].absorbed;
  return faces;
}

void expect_alike(const Faces& block, const Faces& object) {
  // A photon of weight w ≤ 1 leaves by a face or not: its variance is at most the face's share.
  constexpr double sigmas = 4.0;
  for (std::size_t f = 0; f < 6; ++f) {
    EXPECT_NEAR(object.power[f], block.power[f],
                sigmas * std::hypot(object.error[f], block.error[f]))
        << "face " << f;
  }
  const double entering = block.unscattered + block.absorbed +
                          std::accumulate(block.power.begin(), block.power.end(), 0.0);
  const double error = std::sqrt(2.0 * block.unscattered * entering / photons);
  EXPECT_NEAR(object.unscattered, block.unscattered, sigmas * error);
  EXPECT_NEAR(object.absorbed, block.absorbed,
              sigmas * std::sqrt(2.0 * block.absorbed * entering / photons));
}

class ObjectMonteCarloBlock : public ::testing::Test {
 protected:
  void SetUp() override {
    if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  }
};

TEST_F(ObjectMonteCarloBlock, AHomogeneousBoxIsABlock) {
  const Coefficients c = testing::coefficients(0.05, 2.0);
  const Medium medium{Volume<double>(shape, c.kappa), Volume<double>(shape, c.mu)};
  expect_alike(in_block(medium), in_object(ObjectMedium(c)));
}

TEST_F(ObjectMonteCarloBlock, AVolumePlacedInABoxIsABlock) {
  const Medium medium = uneven();
  expect_alike(in_block(medium), in_object(ObjectMedium(std::make_shared<const Medium>(medium),
                                                        Eigen::Affine3d::Identity(), Wrap::clamp)));
}

}  // namespace
}  // namespace kappamu::forward
