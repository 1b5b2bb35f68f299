// Objects for the tests of their models: a mesh with its surface and rays, lights on it.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "forward/object_model.h"
#include "render/embree_caster.h"

namespace kappamu::forward::testing {

struct Object {
  explicit Object(TriangleMesh its_mesh)
      : mesh(std::move(its_mesh)),
        surface(surface_of(mesh)),
        rays(render::make_embree_caster(mesh)) {}

  ObjectProblem problem(const ObjectMedium& medium, double eta,
                        const std::vector<ObjectLight>& lights) const {
    return {mesh, surface, *rays, medium, eta, lights};
  }
  using Where = std::function<bool(std::size_t sample)>;
  static bool everywhere(std::size_t) { return true; }
  double area(const Where& where = everywhere) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < surface.size(); ++i) sum += where(i) ? surface.area[i] : 0.0;
    return sum;
  }
  /// Diffuse light of irradiance 1 where asked.
  ObjectLight diffuse(const Where& where = everywhere) const {
    ObjectLight light;
    for (std::size_t i = 0; i < surface.size(); ++i) light.diffuse.push_back(where(i) ? 1.0 : 0.0);
    return light;
  }
  /// The same by beams of random places and directions: true Lambertian light outside.
  ObjectLight lambertian_beams(int count, const Where& where, std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform;
    std::vector<double> areas;
    for (std::size_t i = 0; i < surface.size(); ++i)
      areas.push_back(where(i) ? surface.area[i] : 0.0);
    std::discrete_distribution<int> sample(areas.begin(), areas.end());
    ObjectLight light;
    for (int i = 0; i < count; ++i) {
      Beam beam;
      beam.triangle = sample(random);
      const auto t = static_cast<std::size_t>(beam.triangle);
      const auto corner = [&](std::size_t k) {
        return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])];
      };
      const double root = std::sqrt(uniform(random)), along = uniform(random);
      beam.position =
          (1.0 - root) * corner(0) + root * (1.0 - along) * corner(1) + root * along * corner(2);
      const Eigen::Vector3d& normal = surface.normal[t];
      const Eigen::Vector3d aside = normal.unitOrthogonal();
      const double cosine = std::sqrt(uniform(random)), sine = std::sqrt(1.0 - cosine * cosine);
      const double turn = 2.0 * std::numbers::pi * uniform(random);
      beam.direction =
          sine * (std::cos(turn) * aside + std::sin(turn) * normal.cross(aside)) - cosine * normal;
      beam.power = area(where) / count;
      light.beams.push_back(beam);
    }
    return light;
  }

  TriangleMesh mesh;
  Surface surface;
  std::unique_ptr<RayCaster> rays;
};

/// κ from absorption and reduced scattering [1/mm].
inline Coefficients coefficients(double absorption, double scattering) {
  return {1.0 / (3.0 * (absorption + scattering)), absorption};
}

/// A volume of random voxels over the object's box, contrast up to `contrast` each way.
inline ObjectMedium random_medium(const Object& object, const Coefficients& mean, double contrast) {
  const Eigen::AlignedBox3d box = bounding_box(object.mesh);
  const GridShape shape{5, 4, 3, 1.0};
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-1.0, 1.0);
  auto volume =
      std::make_shared<Medium>(Medium{Volume<double>(shape, 0.0), Volume<double>(shape, 0.0)});
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    volume->kappa[i] = mean.kappa * std::pow(contrast, exponent(random));
    volume->mu[i] = mean.mu * std::pow(contrast, exponent(random));
  }
  Eigen::Affine3d placed = Eigen::Affine3d::Identity();
  placed.scale(Eigen::Vector3d(5.0, 4.0, 3.0).cwiseQuotient(box.sizes())).translate(-box.min());
  return {volume, placed, Wrap::clamp};
}

}  // namespace kappamu::forward::testing
