#include "render/embree_caster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <type_traits>

#include "core/error.h"

namespace kappamu::render {

namespace {

/// How far before `nearest` Embree's rays start, in its own frame: a hundred roundings of single
/// precision, since at grazing angles a surface's distance is known that much worse than its
/// position.
constexpr double slack = 1e-5;

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
template <class Handle>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

/// One ray in double precision, which Embree's filter reaches through its context; `context` comes
/// first, so that a pointer to one is a pointer to the other.
struct Query {
  RTCIntersectContext context;
  const TriangleMesh* mesh;
  Eigen::Vector3d origin, direction;
  double nearest, farthest;
  std::optional<RayHit> best;
  std::vector<RayHit>* all = nullptr;  ///< takes every hit, where there is one
};
static_assert(std::is_standard_layout_v<RTCIntersectContext>);

/// Where the ray meets the triangle that Embree says it meets: on its plane, or where rounding puts
/// that outside the triangle, at the triangle's nearest weights.
RayHit refined(const Query& query, const RTCHit& candidate) {
  const auto& [a, b, c] = query.mesh->triangles[candidate.primID];
  const Eigen::Vector3d& corner = query.mesh->vertices[static_cast<std::size_t>(a)];
  const Eigen::Vector3d first = query.mesh->vertices[static_cast<std::size_t>(b)] - corner;
  const Eigen::Vector3d second = query.mesh->vertices[static_cast<std::size_t>(c)] - corner;
  const Eigen::Vector3d normal = first.cross(second);
  const Eigen::Vector3d to_corner = corner - query.origin;
  const double distance = normal.dot(to_corner) / normal.dot(query.direction);
  RayHit hit{distance, static_cast<int>(candidate.primID), candidate.u, candidate.v};
  if (std::isfinite(distance)) {
    const Eigen::Vector3d in_plane = distance * query.direction - to_corner;
    hit.u = in_plane.cross(second).dot(normal) / normal.squaredNorm();
    hit.v = first.cross(in_plane).dot(normal) / normal.squaredNorm();
    if (hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.0) return hit;
    hit.u = std::max(0.0, hit.u);
    hit.v = std::max(0.0, hit.v);
  }
  const double sum = std::max(1.0, hit.u + hit.v);
  hit.u /= sum;
  hit.v /= sum;
  hit.distance = (to_corner + hit.u * first + hit.v * second).dot(query.direction) /
                 query.direction.squaredNorm();
  return hit;
}

/// Accepts a candidate that double precision puts within the asked range and before the best so
/// far; or collects it and has Embree go on.
void filter(const RTCFilterFunctionNArguments* arguments) {
  // The context is the first member of the Query it came from.
  auto* query = reinterpret_cast<Query*>(const_cast<RTCIntersectContext*>(arguments->context));
  const RTCHit candidate = rtcGetHitFromHitN(arguments->hit, arguments->N, 0);
  const RayHit hit = refined(*query, candidate);
  const bool within = hit.distance > query->nearest && hit.distance < query->farthest;
  if (query->all != nullptr) {
    if (within) query->all->push_back(hit);
    arguments->valid[0] = 0;
  } else if (within && !(query->best && query->best->distance <= hit.distance)) {
    query->best = hit;
  } else {
    arguments->valid[0] = 0;
  }
}

class EmbreeCaster final : public MovableCaster {
 public:
  explicit EmbreeCaster(const TriangleMesh& mesh) : mesh_(mesh) {
    check(!mesh.triangles.empty(), "embree caster: a mesh without triangles");
    fit_frame();
    device_.reset(rtcNewDevice(nullptr));
    if (!device_) throw_failure();
    build(RTC_SCENE_FLAG_ROBUST, RTC_BUILD_QUALITY_MEDIUM);
  }

  void move(const std::vector<Eigen::Vector3d>& vertices) override {
    mesh_.vertices = vertices;
    fit_frame();
    if (movable_) {
      put_vertices();
      rtcUpdateGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0);
      rtcCommitGeometry(geometry_);
      rtcCommitScene(scene_.get());
    } else {
      movable_ = true;
      build(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC, RTC_BUILD_QUALITY_LOW);
    }
    if (rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE) throw_failure();
  }

  void all_hits(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double nearest,
                double farthest, std::vector<RayHit>& hits) const override {
    hits.clear();
    traced<false>(origin, direction, nearest, farthest, &hits);
    std::sort(hits.begin(), hits.end(),
              [](const RayHit& a, const RayHit& b) { return a.distance < b.distance; });
  }

  std::optional<RayHit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  double nearest, double farthest) const override {
    return traced<false>(origin, direction, nearest, farthest);
  }

  bool any_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double nearest,
               double farthest) const override {
    return traced<true>(origin, direction, nearest, farthest).has_value();
  }

 private:
  void fit_frame() {
    box_ = bounding_box(mesh_);
    centre_ = box_.center();
    half_ = box_.sizes().maxCoeff() / 2.0;
    check(std::isfinite(half_) && half_ > 0.0, "embree caster: a mesh without extent");
    box_.min().array() -= slack * half_;
    box_.max().array() += slack * half_;
  }

  void put_vertices() {
    auto* vertices =
        static_cast<float*>(rtcGetGeometryBufferData(geometry_, RTC_BUFFER_TYPE_VERTEX, 0));
    for (const Eigen::Vector3d& vertex : mesh_.vertices) {
      const Eigen::Vector3f scaled = ((vertex - centre_) / half_).cast<float>();
      vertices = std::copy(scaled.begin(), scaled.end(), vertices);
    }
  }

  /// The scene holds the only geometry, which it owns. That of a dynamic scene is refitted from
  /// then on.
  void build(RTCSceneFlags flags, RTCBuildQuality quality) {
    scene_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(scene_.get(), flags);
    rtcSetSceneBuildQuality(scene_.get(), quality);
    geometry_ = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    if (movable_) rtcSetGeometryBuildQuality(geometry_, RTC_BUILD_QUALITY_REFIT);
    const void* vertices =
        rtcSetNewGeometryBuffer(geometry_, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh_.vertices.size());
    auto* triangles = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry_, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh_.triangles.size()));
    if (vertices == nullptr || triangles == nullptr) throw_failure();
    put_vertices();
    for (const auto& triangle : mesh_.triangles) {
      triangles = std::transform(triangle.begin(), triangle.end(), triangles,
                                 [](int vertex) { return static_cast<unsigned>(vertex); });
    }
    rtcSetGeometryIntersectFilterFunction(geometry_, filter);
    rtcSetGeometryOccludedFilterFunction(geometry_, filter);
    rtcCommitGeometry(geometry_);
    rtcAttachGeometry(scene_.get(), geometry_);
    rtcReleaseGeometry(geometry_);
    rtcCommitScene(scene_.get());
    if (rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE) throw_failure();
  }

  /// The first hit, or any; none where all are collected.
  template <bool any>
  std::optional<RayHit> traced(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                               double nearest, double farthest,
                               std::vector<RayHit>* all = nullptr) const {
    // Where the ray is in the mesh's box, in units of the direction's length.
    double enters = nearest, leaves = farthest;
    for (int axis = 0; axis < 3; ++axis) {
      const double one = (box_.min()[axis] - origin[axis]) / direction[axis];
      const double other = (box_.max()[axis] - origin[axis]) / direction[axis];
      enters = std::fmax(enters, std::fmin(one, other));  // NaN, along a side of the box: no limit
      leaves = std::fmin(leaves, std::fmax(one, other));
    }
    const double length = direction.norm();
    if (!(enters <= leaves) || !(length > 0.0) || !std::isfinite(length)) return std::nullopt;
    if (!origin.allFinite()) return std::nullopt;  // Embree aborts on them

    Query query{{}, &mesh_, origin, direction, nearest, farthest, std::nullopt, all};
    rtcInitIntersectContext(&query.context);
    const Eigen::Vector3d along = direction / length;
    const Eigen::Vector3f start =
        ((origin + enters * direction - centre_) / half_ - slack * along).cast<float>();
    RTCRayHit ray{};
    ray.ray.org_x = start.x();
    ray.ray.org_y = start.y();
    ray.ray.org_z = start.z();
    ray.ray.dir_x = static_cast<float>(along.x());
    ray.ray.dir_y = static_cast<float>(along.y());
    ray.ray.dir_z = static_cast<float>(along.z());
    ray.ray.tfar = static_cast<float>((leaves - enters) * length / half_ + 3.0 * slack);
    ray.ray.mask = ~0U;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    if constexpr (any) {
      rtcOccluded1(scene_.get(), &query.context, &ray.ray);
    } else {
      rtcIntersect1(scene_.get(), &query.context, &ray);
    }
    return query.best;
  }

  [[noreturn]] void throw_failure() const {
    throw InputError("mesh: no memory is left for rays against its " +
                     std::to_string(mesh_.triangles.size()) +
                     " triangles; give a mesh of fewer triangles");
  }

  TriangleMesh mesh_;
  Eigen::AlignedBox3d box_;
  Eigen::Vector3d centre_;
  double half_ = 0.0;
  bool movable_ = false;
  Owned<RTCDevice> device_;
  Owned<RTCScene> scene_;
  RTCGeometry geometry_ = nullptr;
};

}  // namespace

std::unique_ptr<MovableCaster> make_embree_caster(const TriangleMesh& mesh) {
  return std::make_unique<EmbreeCaster>(mesh);
}

}  // namespace kappamu::render
