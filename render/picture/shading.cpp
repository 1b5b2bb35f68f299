#include "render/picture/shading.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "forward/light/walls.h"
#include "render/light/sampling.h"
#include "render/picture/corner_average.h"

namespace kappamu::render {

using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Paths that M₁ is found with, over all triangles of an object, and of each: against twice as many
/// the error of a picture of 32 rays a pixel grows by 2 %.
constexpr std::size_t paths_in_all = 500'000, least_paths = 8, most_paths = 256;

constexpr double infinity = std::numeric_limits<double>::infinity();

Colour of_triangle(const std::array<std::vector<double>, 3>& channels, std::size_t triangle) {
  return {channels[0][triangle], channels[1][triangle], channels[2][triangle]};
}

/// Of radiance inside, what is outside.
double leaves(double eta, double cosine) {
  return (1.0 - fresnel_external(eta, std::clamp(cosine, 1e-6, 1.0))) / (eta * eta);
}

/// Triangles with a corner of one that faces the eye; all without one.
std::vector<char> touching_those_that_face(const WorldObject& object,
                                           const std::optional<Vector3d>& eye) {
  const TriangleMesh& mesh = object.mesh;
  std::vector<char> touching(mesh.triangles.size(), 1), corner(mesh.vertices.size(), 0);
  if (!eye) return touching;
  const Vector3d from = object.world_from_object.inverse() * *eye;
  for (std::size_t t = 0; t < touching.size(); ++t) {
    if (object.surface.normal[t].dot(from - object.surface.position[t]) <= 0.0) continue;
    for (const int c : mesh.triangles[t]) corner[static_cast<std::size_t>(c)] = 1;
  }
  for (std::size_t t = 0; t < touching.size(); ++t) {
    touching[t] = std::any_of(mesh.triangles[t].begin(), mesh.triangles[t].end(),
                              [&](int c) { return corner[static_cast<std::size_t>(c)] != 0; });
  }
  return touching;
}

}  // namespace

Shading::Shading(const World& world, const LightSources& sources, const Environment* environment,
                 const std::vector<ObjectExitance>& exitance, const std::optional<Vector3d>& eye,
                 Progress* progress)
    : world_(world), sources_(sources), environment_(environment), single_(world, sources) {
  for (std::size_t i = 0; i < world.objects().size(); ++i) {
    const WorldObject& object = world.objects()[i];
    const CornerAverage average(object.mesh, object.surface);
    const double eta = object.boundary.eta;
    const double transmitted = eta * eta * (1.0 - object.boundary.r_phi);
    const bool diffuse = !exitance[i].diffuse[0].empty();
    const auto entering = [&](std::size_t t) -> Colour {
      return transmitted * of_triangle(exitance[i].diffuse, t);
    };
    Corners corners;
    corners.normal = average.of<Vector3d>(Vector3d::Zero(), [&](std::size_t t) -> Vector3d {
      return object.world_from_object.rotation * object.surface.normal[t];
    });
    corners.outflow = average.of<Colour>(Colour::Zero(), [&](std::size_t t) -> Colour {
      const Colour all = of_triangle(exitance[i].exitance, t);
      return diffuse ? Colour(all - entering(t)) : all;
    });
    if (diffuse) corners.entering = average.of<Colour>(Colour::Zero(), entering);
    if (directed()) {
      const std::vector<Colour> once = exitance_once(i, eye, progress);
      corners.once = average.of<Colour>(Colour::Zero(), [&](std::size_t t) { return once[t]; });
    }
    corners_.push_back(std::move(corners));
  }
}

/// M₁ of every triangle that the eye may see, or whose corners it may.
std::vector<Colour> Shading::exitance_once(std::size_t index, const std::optional<Vector3d>& eye,
                                           Progress* progress) const {
  const WorldObject& object = world_.objects()[index];
  const std::size_t triangles = object.surface.size();
  const std::size_t paths = std::clamp(paths_in_all / triangles, least_paths, most_paths);
  const std::vector<char> wanted = touching_those_that_face(object, eye);
  std::vector<Colour> once(triangles, Colour::Zero());
  constexpr std::size_t triangles_at_once = 64, triangles_per_update = 2048;
  const auto some = [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (wanted[t] == 0) continue;
      const std::uint64_t key = key_of({index, t});
      WorldHit hit;
      hit.object = index;
      hit.triangle = t;
      hit.normal = object.world_from_object.rotation * object.surface.normal[t];
      for (std::uint32_t i = 0; i < paths; ++i) {
        const auto [on_u, on_v] = sobol_point(i, key);
        hit.position = object.world_from_object * point_on(object.mesh, t, on_u, on_v);
        const auto [u, v] = sobol_point(i, mix(key));
        once[t] += pi * scattered_once(hit, cosine_direction(hit.normal, u, v), i, mix(mix(key)));
      }
      once[t] /= static_cast<double>(paths);
    }
  };
  for (std::size_t first = 0; first < triangles; first += triangles_per_update) {
    const std::size_t last = std::min(triangles, first + triangles_per_update);
    for_pieces(
        last - first, triangles_at_once,
        [&](std::size_t, std::size_t begin, std::size_t end) { some(first + begin, first + end); });
    if (progress == nullptr) continue;
    progress->update("light scattered once",
                     static_cast<double>(last) / static_cast<double>(triangles), "");
  }
  return once;
}

Shading::Point Shading::point_at(const WorldHit& hit, const Vector3d& direction) const {
  Point point{hit, hit.normal, -direction, 1.0};
  const Vector3d smooth =
      interpolated(corners_[hit.object].normal[hit.triangle], hit.u, hit.v).normalized();
  constexpr double grazing = 0.02;  // where the smooth normal turns away, the triangle's is used
  if (smooth.dot(point.view) > grazing) point.normal = smooth;
  const WorldObject& object = world_.objects()[hit.object];
  point.roughness = object.roughness;
  if (object.maps) {
    const Rigid object_from_world = object.world_from_object.inverse();
    const SurfaceMaps::Place place{hit.triangle, hit.u, hit.v, object_from_world * hit.position,
                                   object_from_world.rotation * point.normal};
    const Vector3d bumped = object.world_from_object.rotation * object.maps->normal(place);
    if (bumped.dot(point.view) > grazing) point.normal = bumped;
    point.roughness = object.maps->roughness(place, object.roughness);
    point.reflectance = object.maps->reflectance(place);
  }
  point.cosine = std::clamp(point.normal.dot(point.view), 1e-6, 1.0);
  return point;
}

Shading::Seen Shading::seen(const Vector3d& origin, const Vector3d& direction, std::uint32_t sample,
                            std::uint64_t key) const {
  Seen seen;
  const auto hit = world_.first_hit(origin, direction, 0.0);
  if (!hit) {
    if (environment_ && environment_->visible()) {
      seen.radiance = environment_->radiance(direction);
    }
    return seen;
  }
  seen.object = true;
  if (hit->normal.dot(direction) >= 0.0) return seen;  // a surface's edge, met from behind
  const Point point = point_at(*hit, direction);
  Colour once = Colour::Zero();  // M₁
  if (directed()) {
    once = interpolated(corners_[hit->object].once[hit->triangle], hit->u, hit->v);
    seen.radiance = scattered_once(point.hit, point.view, sample, key_of({key, 3}));
    if (environment_ && environment_->has_beams()) seen.radiance += through(point.hit, point.view);
  }
  seen.radiance += scattered(point, once) + reflected(point, sample, key_of({key, 4}));
  if (point.reflectance.maxCoeff() > 0.0) {
    seen.radiance += reflected_diffusely(point, sample, key_of({key, 6}));
  }
  if (world_.objects()[hit->object].emission.maxCoeff() > 0.0) {
    seen.radiance += emitted(point.hit, point.view, sample, key_of({key, 5}));
  }
  return seen;
}

/// All light scattered inside but the part `once` of the exitance.
Colour Shading::scattered(const Point& point, const Colour& once) const {
  const WorldHit& hit = point.hit;
  const Corners& corners = corners_[hit.object];
  const BoundaryConstants& boundary = world_.objects()[hit.object].boundary;
  const Colour outflow = interpolated(corners.outflow[hit.triangle], hit.u, hit.v);
  Colour radiance = radiance_per_exitance(boundary, point.cosine) * (outflow - once);
  if (!corners.entering.empty()) {
    const Colour entering = interpolated(corners.entering[hit.triangle], hit.u, hit.v);
    const double out =
        (1.0 - fresnel_external(boundary.eta, point.cosine)) / (boundary.eta * boundary.eta);
    radiance += out * entering / (pi * (1.0 - boundary.r_phi));
  }
  return radiance;
}

/// Radiance outside, towards `view`, of light scattered once.
Colour Shading::scattered_once(const WorldHit& hit, const Vector3d& view, std::uint32_t sample,
                               std::uint64_t key) const {
  const double eta = world_.objects()[hit.object].boundary.eta;
  const Vector3d inward = forward::refracted(-view, hit.normal, 1.0 / eta);
  const auto [u, v] = sobol_point(sample, key);
  return leaves(eta, hit.normal.dot(view)) *
         single_.radiance_inside(hit, inward, u, v, lamp(sample, mix(key)));
}

/// The same of lamps that are seen through the object.
Colour Shading::through(const WorldHit& hit, const Vector3d& view) const {
  const double eta = world_.objects()[hit.object].boundary.eta;
  const Vector3d inward = forward::refracted(-view, hit.normal, 1.0 / eta);
  return leaves(eta, hit.normal.dot(view)) * single_.sky_through(hit, inward, *environment_);
}

std::optional<Arrival> Shading::lamp(std::uint32_t sample, std::uint64_t key) const {
  if (environment_ == nullptr || !environment_->has_beams()) return std::nullopt;
  const auto [u, v] = sobol_point(sample, key);
  const Environment::Sample drawn = environment_->sample(u, v);
  return Arrival{-drawn.direction, infinity,
                 environment_->of_lamps(drawn.direction) / drawn.density};
}

/// The same of light that the object emits.
Colour Shading::emitted(const WorldHit& hit, const Vector3d& view, std::uint32_t sample,
                        std::uint64_t key) const {
  const double eta = world_.objects()[hit.object].boundary.eta;
  const Vector3d inward = forward::refracted(-view, hit.normal, 1.0 / eta);
  const auto [u, v] = sobol_point(sample, key);
  return leaves(eta, hit.normal.dot(view)) * single_.emitted(hit, inward, u, v);
}

/// By the surface's own diffuse reflectance, on top of what it lets in and out.
Colour Shading::reflected_diffusely(const Point& point, std::uint32_t sample,
                                    std::uint64_t key) const {
  Colour irradiance = Colour::Zero();
  const Corners& corners = corners_[point.hit.object];
  if (!corners.entering.empty()) {
    const BoundaryConstants& boundary = world_.objects()[point.hit.object].boundary;
    const double transmitted = boundary.eta * boundary.eta * (1.0 - boundary.r_phi);
    irradiance =
        interpolated(corners.entering[point.hit.triangle], point.hit.u, point.hit.v) / transmitted;
  }
  const auto add = [&](const Arrival& arrival) {
    const double cosine = -arrival.direction.dot(point.normal);
    if (cosine <= 0.0 || arrival.direction.dot(point.hit.normal) >= 0.0) return;
    if (arrival.irradiance.maxCoeff() <= 0.0) return;
    if (world_.blocked(point.hit.position, -arrival.direction, arrival.distance)) return;
    irradiance += cosine * arrival.irradiance;
  };
  for (const auto& source : sources_) add(source->at(point.hit.position));
  if (const auto sky = lamp(sample, key)) add(*sky);
  return point.reflectance * irradiance / pi;
}

Colour Shading::reflected(const Point& point, std::uint32_t sample, std::uint64_t key) const {
  const WorldObject& object = world_.objects()[point.hit.object];
  if (object.boundary.eta == 1.0) return Colour::Zero();
  const Ggx surface(object.boundary.eta, point.roughness);
  const Eigen::Matrix3d frame = frame_about(point.normal);
  Colour radiance = Colour::Zero();
  if (!surface.mirror()) radiance += reflected_lights(point, surface, frame);
  const auto [u, v] = sobol_point(sample, key);
  radiance += reflected_surroundings(point, surface, frame, u, v);
  if (!environment_ || environment_->even() || surface.mirror()) return radiance;

  const auto [bright_u, bright_v] = sobol_point(sample, mix(key));
  const Environment::Sample bright = environment_->sample(bright_u, bright_v);
  const Vector3d view = frame.transpose() * point.view;
  const Vector3d light = frame.transpose() * bright.direction;
  const double reflectance = surface.reflectance(view, light);
  if (reflectance > 0.0 && !world_.blocked(point.hit.position, bright.direction, infinity)) {
    radiance += bright.radiance * reflectance / (bright.density + surface.density(view, light));
  }
  return radiance;
}

Colour Shading::reflected_lights(const Point& point, const Ggx& surface,
                                 const Eigen::Matrix3d& frame) const {
  Colour radiance = Colour::Zero();
  const Vector3d view = frame.transpose() * point.view;
  for (const auto& source : sources_) {
    const Arrival arrival = source->at(point.hit.position);
    const double reflectance = surface.reflectance(view, frame.transpose() * -arrival.direction);
    if (reflectance <= 0.0 || arrival.irradiance.maxCoeff() <= 0.0) continue;
    if (world_.blocked(point.hit.position, -arrival.direction, arrival.distance)) continue;
    radiance += reflectance * arrival.irradiance;
  }
  return radiance;
}

/// One direction drawn by the surface: the environment, weighted against reflected()'s own sample
/// of it, or another surface's scattered light.
Colour Shading::reflected_surroundings(const Point& point, const Ggx& surface,
                                       const Eigen::Matrix3d& frame, double u, double v) const {
  const Vector3d view = frame.transpose() * point.view;
  const Vector3d light = surface.sample(view, u, v);
  if (light.z() <= 0.0) return Colour::Zero();
  const Vector3d direction = frame * light;
  double weight = 0.0, density = 0.0;
  if (surface.mirror()) {
    weight = fresnel_external(world_.objects()[point.hit.object].boundary.eta, point.cosine);
  } else {
    density = surface.density(view, light);
    if (density <= 0.0) return Colour::Zero();
    weight = surface.reflectance(view, light) / density;
  }
  const auto hit = world_.first_hit(point.hit.position, direction, world_.skin());
  if (hit) {
    if (hit->normal.dot(direction) >= 0.0) return Colour::Zero();
    return weight * scattered(point_at(*hit, direction), Colour::Zero());
  }
  if (!environment_) return Colour::Zero();
  if (!surface.mirror()) weight *= density / (density + environment_->density(direction));
  return weight * environment_->radiance(direction);
}

}  // namespace kappamu::render
