// What enters concave bodies of an environment, against random paths of the test's own: its
// triangles, its directions, its sky and its intersections.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/optics.h"
#include "io/image/image_file.h"
#include "render/light/incident_light.h"
#include "tests/own_folder.h"
#include "tests/render/made_scene.h"

namespace kappamu::render {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr double eta = 1.4;
constexpr int sky_width = 24, sky_height = 12;

/// A profile (r, z) turned about the z axis, `parts` around.
TriangleMesh turned(const std::vector<std::array<double, 2>>& profile, int parts) {
  TriangleMesh mesh;
  const int rings = static_cast<int>(profile.size());  // the first and last lie on the axis
  for (const auto& [r, z] : profile) {
    for (int k = 0; k < (r > 0.0 ? parts : 1); ++k) {
      const double angle = 2.0 * pi * k / parts;
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
  }
  const auto vertex = [&](int ring, int k) {
    if (ring == 0) return 0;
    return ring == rings - 1 ? static_cast<int>(mesh.vertices.size()) - 1
                             : 1 + (ring - 1) * parts + k % parts;
  };
  for (int ring = 0; ring + 1 < rings; ++ring) {
    for (int k = 0; k < parts; ++k) {
      if (ring > 0)
        mesh.triangles.push_back({vertex(ring, k), vertex(ring, k + 1), vertex(ring + 1, k)});
      if (ring + 2 < rings) {
        mesh.triangles.push_back(
            {vertex(ring, k + 1), vertex(ring + 1, k + 1), vertex(ring + 1, k)});
      }
    }
  }
  return mesh;
}

/// Open upwards (+z): from the outer pole over the rim to the inner pole.
TriangleMesh bowl() {
  std::vector<std::array<double, 2>> profile;
  constexpr int parts = 7;
  for (int k = 0; k <= parts; ++k) {
    const double angle = 0.5 * pi * k / parts;
    profile.push_back({k == 0 ? 0.0 : 10.0 * std::sin(angle), -10.0 * std::cos(angle)});
  }
  for (int k = parts; k >= 0; --k) {
    const double angle = 0.5 * pi * k / parts;
    profile.push_back({k == 0 ? 0.0 : 8.5 * std::sin(angle), -8.5 * std::cos(angle)});
  }
  return turned(profile, 20);
}

TriangleMesh l_prism() {
  const std::vector<std::array<double, 2>> corner{{0, 0}, {20, 0}, {20, 6},
                                                  {7, 6}, {7, 16}, {0, 16}};
  TriangleMesh mesh;
  for (const double z : {0.0, 9.0}) {
    for (const auto& [x, y] : corner) mesh.vertices.emplace_back(x, y, z);
  }
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + 6, b + 6, c + 6});
  }
  for (int k = 0; k < 6; ++k) {
    const int next = (k + 1) % 6;
    mesh.triangles.push_back({k, next, next + 6});
    mesh.triangles.push_back({k, next + 6, k + 6});
  }
  return mesh;
}

/// Top row up (+y), columns from +z by -x to the centre, -z.
using Sky = std::function<double(const Vector3d&)>;

struct Estimate {
  double mean = 0.0, deviation = 0.0;
  double direct = 0.0;  ///< of the mean, without reflections
  double often = 0.0;   ///< of the mean, after more than four
};

/// Power that enters, before what leaves again.
Estimate entering(const TriangleMesh& mesh, const Sky& sky, unsigned seed) {
  struct Facet {
    Vector3d corner, one, other, normal;
  };
  std::vector<Facet> facets;
  std::vector<double> area;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    const Vector3d one = at(1) - at(0), other = at(2) - at(0), normal = one.cross(other);
    facets.push_back({at(0), one, other, normal.normalized()});
    area.push_back(0.5 * normal.norm());
  }
  const auto met = [&](const Vector3d& from, const Vector3d& along) {
    std::optional<std::pair<double, std::size_t>> nearest;
    for (std::size_t f = 0; f < facets.size(); ++f) {
      const Facet& facet = facets[f];
      const Vector3d p = along.cross(facet.other);
      const double determinant = facet.one.dot(p);
      if (std::abs(determinant) < 1e-14) continue;
      const Vector3d s = from - facet.corner;
      const double u = s.dot(p) / determinant;
      if (u < 0.0 || u > 1.0) continue;
      const Vector3d q = s.cross(facet.one);
      const double v = along.dot(q) / determinant;
      if (v < 0.0 || u + v > 1.0) continue;
      const double t = facet.other.dot(q) / determinant;
      if (t > 1e-7 && (!nearest || t < nearest->first)) nearest.emplace(t, f);
    }
    return nearest;
  };
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::discrete_distribution<std::size_t> by_area(area.begin(), area.end());
  constexpr int paths = 60'000;
  double sum = 0.0, squares = 0.0, direct = 0.0, often = 0.0;
  for (int path = 0; path < paths; ++path) {
    const Facet& start = facets[by_area(random)];
    double u = uniform(random), v = uniform(random);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    Vector3d point = start.corner + u * start.one + v * start.other;
    const double sine = std::sqrt(uniform(random)), turn = 2.0 * pi * uniform(random);
    const double cosine = std::sqrt(1.0 - sine * sine);
    const Vector3d across = start.one.normalized();
    Vector3d along = cosine * start.normal +
                     sine * (std::cos(turn) * across + std::sin(turn) * start.normal.cross(across));
    double share = 1.0 - fresnel_external(eta, cosine);
    int reflections = 0;
    while (const auto hit = met(point, along)) {
      const Facet& facet = facets[hit->second];
      const double facing = -along.dot(facet.normal);
      share *= facing > 0.0 ? fresnel_external(eta, facing) : 0.0;
      if (share < 1e-9) break;
      point += hit->first * along;
      along += 2.0 * facing * facet.normal;
      ++reflections;
    }
    const double value = share < 1e-9 ? 0.0 : share * sky(along);
    sum += value;
    squares += value * value;
    if (reflections == 0) direct += value;
    if (reflections > 4) often += value;
  }
  const double whole = pi * std::accumulate(area.begin(), area.end(), 0.0);
  const double mean = sum / paths;
  return {whole * mean, whole * std::sqrt((squares / paths - mean * mean) / paths),
          whole * direct / paths, whole * often / paths};
}

class ConcaveEnvironment : public testing::Test {
 protected:
  /// `mesh` in a scene under `light`.
  double ours(const TriangleMesh& mesh, const EnvironmentLight& light) const {
    std::ofstream file(folder_ / "body.obj");
    file.precision(17);
    for (const Vector3d& v : mesh.vertices) file << "v " << v.transpose() << "\n";
    for (const auto& t : mesh.triangles) {
      file << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
    }
    file.close();
    const Eigen::AlignedBox3d box = bounding_box(mesh);
    Scene scene = sphere_scene();
    SceneObject& object = scene.objects[0];
    object.shape = folder_ / "body.obj";
    object.size_mm = box.sizes().maxCoeff();
    object.position_mm = box.center();
    object.finish.eta = eta;
    scene.lights.emplace_back(light);
    std::vector<std::string> warnings;
    const World world(scene, warnings);
    const auto environment = make_environment(scene.lights);
    Progress silent;
    const IncidentLight incident = incident_light(world, 0, {}, &*environment, 11, silent);
    const Surface& surface = world.objects()[0].surface;
    double sum = 0.0;
    for (std::size_t t = 0; t < surface.size(); ++t) {
      sum += surface.area[t] * incident.channels[0].diffuse[t];
    }
    return eta * eta * (1.0 - boundary_constants(eta).r_phi) * sum;
  }
  void expect_agreement(const TriangleMesh& mesh, unsigned seed) {
    Image<float> image(sky_width, sky_height, 3, 0.2F);
    for (int y = 0; y < sky_height; ++y) {
      for (int x = 0; x < sky_width; ++x)
        image(x, y, 0) += 0.1F * static_cast<float>((x + 2 * y) % 9);
    }
    image(5, 3, 0) = 30.0F;
    image(16, 7, 0) = 12.0F;
    io::write_float_image(folder_ / "sky.exr", image);
    const Sky uneven = [&](const Vector3d& d) {
      const double u = std::atan2(d.x(), -d.z()) / (2.0 * pi) + 0.5,
                   v = std::acos(std::clamp(d.y(), -1.0, 1.0)) / pi;
      return static_cast<double>(image(std::min(sky_width - 1, static_cast<int>(u * sky_width)),
                                       std::min(sky_height - 1, static_cast<int>(v * sky_height)),
                                       0));
    };
    for (const bool even : {true, false}) {
      EnvironmentLight light;
      light.radiance = Colour::Ones();
      if (!even) light.image = folder_ / "sky.exr";
      const Estimate theirs =
          entering(mesh, even ? Sky([](const Vector3d&) { return 1.0; }) : uneven, seed);
      const double found = ours(mesh, light);
      std::printf(
          "%s sky: %.2f, paths %.2f +- %.2f, of it mirrored %.2f %%, over four times %.1e\n",
          even ? "even" : "uneven", found, theirs.mean, theirs.deviation,
          100.0 * (1.0 - theirs.direct / theirs.mean), theirs.often / theirs.mean);
      EXPECT_LT(theirs.often, 1e-4 * theirs.mean);
      // Of our own rays, 4 million on the body.
      constexpr double noise = 1e-3;
      EXPECT_NEAR(found, theirs.mean, 4.0 * theirs.deviation + noise * theirs.mean);
      mirrored_ = std::max(mirrored_, (theirs.mean - theirs.direct) / theirs.deviation);
    }
  }
  const OwnFolder folder_;
  double mirrored_ = 0.0;  ///< what surfaces mirrored, in deviations of the whole
};

TEST_F(ConcaveEnvironment, EntersABowlAsPathsSay) {
  expect_agreement(bowl(), 301);
  EXPECT_GT(mirrored_, 4.0);  // seen at this precision, so that it cannot be left out
}
TEST_F(ConcaveEnvironment, EntersAnLPrismAsPathsSay) {
  expect_agreement(l_prism(), 302);
}
TEST_F(ConcaveEnvironment, EntersATorusAsPathsSay) {
  expect_agreement(torus_mesh(10.0, 4.0, 14), 303);
}

}  // namespace
}  // namespace kappamu::render
