// Is the stated error the true one? Random media whose voxels lie askew to the cubes, on shapes and
// under lights drawn at random; the truth is the same model on some ten times as many cubes.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/mesh/shapes.h"
#include "core/mesh/surface_norm.h"
#include "embedded_test_tools.h"
#include "forward/embedded/body_solve.h"
#include "forward/embedded/embedded_model.h"

namespace kappamu::forward::embedded {
namespace {

constexpr double eta = 1.3;

class Draw {
 public:
  explicit Draw(unsigned seed) : generator_(seed) {}
  double between(double low, double high) { return low + (high - low) * uniform_(generator_); }
  double log_between(double low, double high) {
    return low * std::pow(high / low, uniform_(generator_));
  }
  Eigen::Vector3d point(double extent) {
    return {between(0.0, extent), between(0.0, extent), between(0.0, extent)};
  }

 private:
  std::mt19937 generator_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
};

/// Voxels of a third to an eighth of the object, κ log-uniform over a contrast of 2 to 100.
ObjectMedium random_medium(Draw& draw, double extent) {
  const double voxel = extent / draw.between(3.0, 8.0);
  const GridShape shape{8, 8, 8, voxel};
  auto volume = std::make_shared<Medium>(Medium{Volume<double>(shape), Volume<double>(shape)});
  const double contrast = draw.log_between(2.0, 100.0);
  const double kappa = draw.log_between(0.05, 1.0), mu = draw.log_between(0.001, 0.05);
  for (std::size_t k = 0; k < shape.cells(); ++k) {
    volume->kappa[k] = kappa * draw.log_between(1.0 / std::sqrt(contrast), std::sqrt(contrast));
    volume->mu[k] = mu * draw.log_between(0.3, 3.0);
  }
  Eigen::Affine3d placed = Eigen::Affine3d::Identity();
  placed.translate(draw.point(voxel));
  placed.rotate(Eigen::AngleAxisd(draw.between(0.0, 3.0), draw.point(1.0).normalized()));
  return ObjectMedium(volume, placed, Wrap::mirror);
}

ObjectLight random_light(Draw& draw, const Surface& surface) {
  const Eigen::Vector3d from = (draw.point(2.0) - Eigen::Vector3d::Ones()).normalized();
  const bool beams = draw.between(0.0, 1.0) < 0.5;
  ObjectLight light;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const double cosine = surface.normal[t].dot(from);
    if (!beams) {
      light.diffuse.push_back(0.5 + 0.5 * cosine);
    } else if (cosine > 0.05) {
      light.beams.push_back(
          {static_cast<int>(t), surface.position[t], -from, cosine * surface.area[t]});
    }
  }
  return light;
}

TEST(EmbeddedPopulation, TheStatedErrorIsAtLeastTheTrueOneInNineOfTenRandomMedia) {
  constexpr int media = 20, wanted = 18;
  const std::array<const char*, 4> shapes{"torus", "cylinder", "slab", "box-with-void"};
  int kept = 0;
  for (unsigned seed = 0; seed < media; ++seed) {
    Draw draw(1000 + seed);
    const double size = 8.0;
    const TriangleMesh mesh = make_shape(shapes[seed % shapes.size()], size, 16);
    const Surface surface = surface_of(mesh);
    const auto rays = make_caster(mesh);
    const ObjectMedium medium = random_medium(draw, size);
    const std::vector<ObjectLight> lights{random_light(draw, surface)};
    const ObjectProblem problem{mesh, surface, *rays, medium, eta, lights};
    Progress progress;
    ObjectOptions options;
    options.device = "reference";
    options.tolerance = 0.05;
    const ObjectResult coarse = EmbeddedModel().solve(problem, options, progress);
    options.tolerance = std::max(0.001, 0.1 * coarse.error_estimate[0]);
    options.max_elements = 15 * coarse.elements;
    const ObjectResult fine = EmbeddedModel().solve(problem, options, progress);
    const double error = surface_difference(surface, coarse.exitance, fine.exitance) /
                         surface_norm(surface, fine.exitance);
    if (error <= coarse.error_estimate[0]) ++kept;
    RecordProperty("medium_" + std::to_string(seed),
                   std::to_string(error / coarse.error_estimate[0]));
  }
  EXPECT_GE(kept, wanted) << "of " << media;
}

}  // namespace
}  // namespace kappamu::forward::embedded
