#include "render/fur/fur_shading.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/edges.h"

namespace kappamu::render {

using Eigen::Vector3d;
using forward::shells::SeenHair;

namespace {

/// Fins fade in where the cosine of normal and eye falls below this.
constexpr double silhouette = 0.3;
/// Hair that lets through no more than this hides what lies behind, as in forward/shells/frame.h.
constexpr double opaque = 0.01;

const Vector3d& vertex(const TriangleMesh& mesh, int i) {
  return mesh.vertices[static_cast<std::size_t>(i)];
}

}  // namespace

FurShading::FurShading(const World& world, const LightSources& sources,
                       const Environment* environment, const std::vector<ObjectExitance>& exitance,
                       const Vector3d& eye, const Furs& furs)
    : Shading(world, sources, environment, exitance, eye),
      world_(world),
      furs_(furs),
      skin_(world, no_sources_, nullptr, exitance, eye) {
  TriangleMesh all;
  for (std::size_t i = 0; i < furs.size(); ++i) {
    if (!furs[i]) continue;
    add_shells(static_cast<int>(i), all);
    if (furs[i]->fur().fins) add_fins(static_cast<int>(i), eye, all);
  }
  shells_ = make_embree_caster(all);
}

void FurShading::add_shells(int fur, TriangleMesh& all) {
  const FurryObject& furry = *furs_[static_cast<std::size_t>(fur)];
  const WorldObject& object = furry.object();
  for (int layer = 0; layer < furry.layers(); ++layer) {
    const int first = static_cast<int>(all.vertices.size());
    const double share = (layer + 0.5) / furry.layers();
    for (std::size_t v = 0; v < object.mesh.vertices.size(); ++v) {
      all.vertices.push_back(
          object.world_from_object *
          (object.mesh.vertices[v] + share * furry.length_mm(v) * furry.frames()[v].col(2)));
    }
    for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = object.mesh.triangles[t];
      all.triangles.push_back({first + a, first + b, first + c});
      shown_.push_back({fur, static_cast<int>(t), layer});
    }
  }
}

void FurShading::add_fins(int fur, const Vector3d& eye, TriangleMesh& all) {
  const FurryObject& furry = *furs_[static_cast<std::size_t>(fur)];
  const WorldObject& object = furry.object();
  const Vector3d from = object.world_from_object.inverse() * eye;
  for (std::size_t t = 0; t < object.mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = object.mesh.triangles[t][static_cast<std::size_t>(k)];
      const int b = object.mesh.triangles[t][static_cast<std::size_t>((k + 1) % 3)];
      if (a > b) continue;  // the neighbour's
      const Vector3d normal_a = furry.frames()[static_cast<std::size_t>(a)].col(2);
      const Vector3d normal_b = furry.frames()[static_cast<std::size_t>(b)].col(2);
      const Vector3d middle = 0.5 * (vertex(object.mesh, a) + vertex(object.mesh, b));
      if (std::abs((normal_a + normal_b).normalized().dot((from - middle).normalized())) >
          silhouette) {
        continue;
      }
      const int first = static_cast<int>(all.vertices.size());
      const double height_a = furry.length_mm(static_cast<std::size_t>(a)),
                   height_b = furry.length_mm(static_cast<std::size_t>(b));
      for (const Vector3d& corner : {vertex(object.mesh, a), vertex(object.mesh, b),
                                     Vector3d(vertex(object.mesh, b) + height_b * normal_b),
                                     Vector3d(vertex(object.mesh, a) + height_a * normal_a)}) {
        all.vertices.push_back(object.world_from_object * corner);
      }
      all.triangles.push_back({first, first + 1, first + 2});
      all.triangles.push_back({first, first + 2, first + 3});
      shown_.push_back({fur, static_cast<int>(t), 0, true, false, k});
      shown_.push_back({fur, static_cast<int>(t), 0, true, true, k});
    }
  }
}

void FurShading::add_hit(const RayHit& hit, const Vector3d& direction, SeenHair& sum) const {
  const Shown& shown = shown_[static_cast<std::size_t>(hit.triangle)];
  const FurryObject& furry = *furs_[static_cast<std::size_t>(shown.fur)];
  const auto& corners = furry.object().mesh.triangles[static_cast<std::size_t>(shown.triangle)];
  double u = hit.u, v = hit.v;
  int layer = shown.layer;
  if (shown.fin) {
    // Along the edge and up, from the weights of the fin's half.
    const double along = shown.upper ? hit.u : hit.u + hit.v,
                 up = shown.upper ? hit.u + hit.v : hit.v;
    layer = std::min(static_cast<int>(up * furry.layers()), furry.layers() - 1);
    std::array<double, 3> share{};
    share[static_cast<std::size_t>(shown.edge)] = 1.0 - along;
    share[static_cast<std::size_t>((shown.edge + 1) % 3)] = along;
    u = share[1];
    v = share[2];
  }
  Vector3d normal = Vector3d::Zero();
  const std::array<double, 3> share{1.0 - u - v, u, v};
  for (std::size_t c = 0; c < 3; ++c) {
    normal += share[c] * furry.frames()[static_cast<std::size_t>(corners[c])].col(2);
  }
  const double cosine =
      std::abs((furry.object().world_from_object.rotation * normal.normalized()).dot(direction));
  const double faded = shown.fin ? std::max(0.0, 1.0 - cosine / silhouette) : 1.0;
  if (faded <= 0.0) return;
  const FurryObject::Layer met =
      furry.seen(static_cast<std::size_t>(shown.triangle), u, v, layer, -direction);
  if (met.density < 1e-4) return;
  const double alpha = faded * furry.opacity(met.density, shown.fin ? 1.0 : cosine);
  sum.radiance += sum.transmittance * alpha * met.radiance;
  sum.transmittance *= 1.0 - alpha;
}

Shading::Seen FurShading::seen(const Vector3d& origin, const Vector3d& direction,
                               std::uint32_t sample, std::uint64_t key) const {
  const auto body = world_.first_hit(origin, direction, 0.0);
  const double farthest = body ? body->distance : std::numeric_limits<double>::infinity();
  SeenHair hair;
  std::vector<RayHit> hits;
  shells_->all_hits(origin, direction, 0.0, farthest, hits);
  double nearest = 0.0;
  for (const RayHit& hit : hits) {
    if (hair.transmittance <= opaque) break;
    if (hit.distance < nearest) continue;  // the edge's other triangle
    add_hit(hit, direction, hair);
    nearest = hit.distance + world_.skin();
  }
  Seen behind;
  if (hair.transmittance > opaque) {
    behind = body && furs_[body->object] ? skin_.seen(origin, direction, sample, key)
                                         : Shading::seen(origin, direction, sample, key);
  }
  return {hair.radiance + hair.transmittance * behind.radiance,
          behind.object || hair.transmittance < 0.5};
}

std::unique_ptr<Shading> make_shading(const World& world, const LightSources& sources,
                                      const Environment* environment,
                                      const std::vector<ObjectExitance>& exitance,
                                      const Vector3d& eye, const Furs& furs) {
  if (std::all_of(furs.begin(), furs.end(), [](const auto& fur) { return !fur; })) {
    return std::make_unique<Shading>(world, sources, environment, exitance, eye);
  }
  return std::make_unique<FurShading>(world, sources, environment, exitance, eye, furs);
}

}  // namespace kappamu::render
