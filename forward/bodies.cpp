#include "forward/bodies.h"

#include <Eigen/Geometry>
#include <map>
#include <numeric>

namespace kappamu::forward {

namespace {

class Union {
 public:
  explicit Union(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int k) {
    while (at(k) != k) k = at(k) = at(at(k));
    return k;
  }
  void join(int a, int b) { at(root(a)) = root(b); }

 private:
  int& at(int k) { return parent_[static_cast<std::size_t>(k)]; }
  std::vector<int> parent_;
};

/// At most this many rays leave a shell's inner side to find what else bounds its material.
constexpr std::size_t rays_per_shell = 64;

}  // namespace

std::vector<Body> bodies(const TriangleMesh& mesh, const RayCaster& rays) {
  Union vertices(mesh.vertices.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    vertices.join(a, b);
    vertices.join(b, c);
  }
  std::map<int, std::vector<int>> shells;  // by their vertices' root, triangles in order
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    shells[vertices.root(mesh.triangles[t][0])].push_back(static_cast<int>(t));
  }
  if (shells.size() > 1) {
    const Surface surface = surface_of(mesh);
    const double size = bounding_box(mesh).sizes().maxCoeff();
    for (const auto& [root, triangles] : shells) {
      const std::size_t step = 1 + triangles.size() / rays_per_shell;
      for (std::size_t k = 0; k < triangles.size(); k += step) {
        const auto t = static_cast<std::size_t>(triangles[k]);
        const Eigen::Vector3d inward = -surface.normal[t];
        const auto hit = rays.first_hit(surface.position[t], inward, 1e-9 * size);
        if (!hit) continue;
        const auto other = static_cast<std::size_t>(hit->triangle);
        if (surface.normal[other].dot(inward) > 0.0) {
          vertices.join(root, mesh.triangles[other][0]);
        }
      }
    }
  }
  std::map<int, int> number;
  std::vector<Body> result;
  std::vector<int> renamed(mesh.vertices.size(), -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [place, made] =
        number.try_emplace(vertices.root(mesh.triangles[t][0]), static_cast<int>(result.size()));
    if (made) result.emplace_back();
    Body& body = result[static_cast<std::size_t>(place->second)];
    std::array<int, 3> corners = mesh.triangles[t];
    for (int& corner : corners) {
      int& name = renamed[static_cast<std::size_t>(corner)];
      if (name < 0) {
        name = static_cast<int>(body.mesh.vertices.size());
        body.mesh.vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)]);
      }
      corner = name;
    }
    body.mesh.triangles.push_back(corners);
    body.triangle.push_back(static_cast<int>(t));
  }
  return result;
}

std::vector<ObjectLight> lights_of(const Body& body, const std::vector<int>& local,
                                   const std::vector<ObjectLight>& lights) {
  std::vector<ObjectLight> result;
  for (const ObjectLight& light : lights) {
    ObjectLight mine;
    for (Beam beam : light.beams) {
      beam.triangle = local[static_cast<std::size_t>(beam.triangle)];
      if (beam.triangle >= 0) mine.beams.push_back(beam);
    }
    if (!light.diffuse.empty()) {
      for (const int t : body.triangle) {
        mine.diffuse.push_back(light.diffuse[static_cast<std::size_t>(t)]);
      }
    }
    result.push_back(std::move(mine));
  }
  return result;
}

std::optional<RayHit> BodyRays::first_hit(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double nearest,
                                          double farthest) const {
  for (;;) {
    std::optional<RayHit> hit = all_.first_hit(origin, direction, nearest, farthest);
    if (!hit) return hit;
    const int local = local_[static_cast<std::size_t>(hit->triangle)];
    if (local >= 0) {
      hit->triangle = local;
      return hit;
    }
    nearest = hit->distance;
  }
}

}  // namespace kappamu::forward
