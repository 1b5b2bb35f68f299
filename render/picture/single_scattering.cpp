#include "render/picture/single_scattering.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "core/optics.h"
#include "forward/light/walls.h"

namespace kappamu::render {

using Eigen::Vector3d;

namespace {

/// Optical depth that less than a millionth of the light crosses: none of it is looked for.
constexpr double dark = 14.0;

struct Scattering {
  Colour extinction;  ///< σt' = 1/(3κ) [1/mm]
  Colour scattering;  ///< σs' = σt' − μ [1/mm]
};

Scattering scattering_at(const WorldObject& object, const Vector3d& point) {
  Scattering s;
  for (int c = 0; c < 3; ++c) {
    const auto& medium = object.media.channels[static_cast<std::size_t>(c)];
    const Coefficients here = medium->at(point);
    s.extinction[c] = 1.0 / (3.0 * here.kappa);
    s.scattering[c] = std::max(0.0, s.extinction[c] - here.mu);
  }
  return s;
}

/// Of all channels [mm].
double longest_free_path(const WorldObject& object) {
  double longest = 0.0;
  for (const auto& medium : object.media.channels) {
    longest = std::max(longest, 3.0 * medium->largest().kappa);
  }
  return longest;
}

/// Parts of this length have one value each: half a voxel. None: as long as all of it.
int parts_of(const WorldObject& object, double length) {
  constexpr double most = 4096.0;
  const auto voxel = object.media.channels[0]->voxel_mm();
  return voxel ? static_cast<int>(std::clamp(std::ceil(2.0 * length / *voxel), 1.0, most)) : 1;
}

/// Along the camera's ray inside an object, from its surface to where it leaves.
class EyePath {
 public:
  EyePath(const WorldObject& object, const Vector3d& from, const Vector3d& along, double length,
          bool lit_from_behind)
      : object_(object), from_(from), along_(along), left_(parts_of(object, length)) {
    part_mm_ = length / left_;
    parts_.reserve(static_cast<std::size_t>(std::min(left_, 12)));
    while (lit_from_behind && left_ > 0 && depth_.minCoeff() < through) walk();
    // Who sees through the object draws within it.
    if (left_ == 0) {
      within_ = 1.0 - (-depth_).exp();
      even_ = (depth_ < through).select(Colour::Constant(even_share), Colour::Zero());
      whole_ = depth_;
    }
  }

  /// By the light that a channel, picked by chance, still lets through; where one sees through the
  /// object, also evenly over its depth: there light from behind grows as that to the eye falls.
  /// None: beyond the object.
  std::optional<double> drawn(double u, double v) {
    const double which = 3.0 * u;
    const int channel = std::min(2, static_cast<int>(which));
    const bool evenly = which - channel < even_[channel];
    const double depth = evenly ? v * whole_[channel] : -std::log1p(-v * within_[channel]);
    while (left_ > 0 && depth_[channel] <= depth) walk();
    if (depth_[channel] <= depth) return std::nullopt;
    std::size_t i = parts_.size() - 1;
    while (i > 0 && parts_[i].depth[channel] > depth) --i;
    const double into = (depth - parts_[i].depth[channel]) / parts_[i].here.extinction[channel];
    return (static_cast<double>(i) + std::clamp(into / part_mm_, 0.0, 1.0)) * part_mm_;
  }

  /// Of drawn() [1/mm].
  double density(double distance) const {
    const Part& part = at(distance);
    const Colour seen = (-depth_at(part, distance)).exp();
    return (part.here.extinction * ((1.0 - even_) * seen / within_ + even_ / whole_)).mean();
  }

  /// Of light that sets out there for the eye, what arrives.
  Colour arrives(double distance) const { return (-depth_at(at(distance), distance)).exp(); }

  /// Of irradiance there, what is scattered towards the eye and arrives [1/(mm sr)].
  Colour scattered_to_eye(double distance) const {
    const Part& part = at(distance);
    return part.here.scattering / (4.0 * std::numbers::pi) * (-depth_at(part, distance)).exp();
  }

 private:
  /// One value of the medium.
  struct Part {
    Scattering here;
    Colour depth;  ///< where it begins
  };
  /// Optical depth that light from behind is looked for through, and the share of draws for it.
  static constexpr double through = 8.0, even_share = 0.3;

  void walk() {
    const double middle = (static_cast<double>(parts_.size()) + 0.5) * part_mm_;
    parts_.push_back({scattering_at(object_, from_ + middle * along_), depth_});
    depth_ += part_mm_ * parts_.back().here.extinction;
    --left_;
  }
  const Part& at(double distance) const {
    return parts_[std::min(parts_.size() - 1, static_cast<std::size_t>(distance / part_mm_))];
  }
  Colour depth_at(const Part& part, double distance) const {
    const auto begin = static_cast<double>(&part - parts_.data()) * part_mm_;
    return part.depth + (distance - begin) * part.here.extinction;
  }

  const WorldObject& object_;
  const Vector3d from_, along_;
  double part_mm_ = 0.0;
  int left_ = 0;  ///< parts not walked
  std::vector<Part> parts_;
  Colour depth_ = Colour::Zero();   ///< of all that is walked
  Colour within_ = Colour::Ones();  ///< share of the light's draws
  Colour even_ = Colour::Zero();    ///< that of even ones
  Colour whole_ = Colour::Ones();   ///< depth that these are of
};

}  // namespace

Colour SingleScattering::optical_depth(const WorldObject& object, const Vector3d& from,
                                       const Vector3d& to) const {
  const double length = (to - from).norm();
  const int steps = parts_of(object, length);
  Colour sum = Colour::Zero();
  for (int i = 0; i < steps; ++i) {
    sum += scattering_at(object, from + (i + 0.5) / steps * (to - from)).extinction;
  }
  return sum * (length / steps);
}

Colour SingleScattering::arriving(std::size_t object_index, const Vector3d& point,
                                  const Arrival& arrival) const {
  if (arrival.irradiance.maxCoeff() <= 0.0) return Colour::Zero();
  const WorldObject& object = world_.objects()[object_index];
  const double free_path = longest_free_path(object);
  const Vector3d towards = -arrival.direction;
  const auto exit =
      world_.first_hit(point, towards, 0.0, std::min(arrival.distance, dark * free_path));
  if (!exit || exit->object != object_index) return Colour::Zero();
  const double cos_outside = exit->normal.dot(towards);
  if (cos_outside <= 0.0) return Colour::Zero();
  if (world_.blocked(exit->position, towards, arrival.distance - exit->distance)) {
    return Colour::Zero();
  }
  const double eta = object.boundary.eta;
  const double cos_inside = std::sqrt(1.0 - (1.0 - cos_outside * cos_outside) / (eta * eta));
  const double stretch = cos_outside / cos_inside;
  const Rigid object_from_world = object.world_from_object.inverse();
  const Colour depth =
      optical_depth(object, object_from_world * point, object_from_world * exit->position) *
      stretch;
  return arrival.irradiance * (1.0 - fresnel_external(eta, std::min(1.0, cos_outside))) * stretch *
         (-depth).exp();
}

Colour SingleScattering::radiance_inside(const WorldHit& hit, const Vector3d& inward, double u,
                                         double v, const std::optional<Arrival>& sky) const {
  const WorldObject& object = world_.objects()[hit.object];
  const Rigid object_from_world = object.world_from_object.inverse();
  const double free_path = longest_free_path(object);
  const bool even = std::all_of(object.media.channels.begin(), object.media.channels.end(),
                                [](const auto& medium) { return medium->homogeneous(); });
  const double farthest = std::min(world_.diameter(), dark * free_path);
  // In an even medium no draw weighs more than the first: what lies behind is not asked for.
  std::optional<WorldHit> end;
  if (!even) end = world_.first_hit(hit.position, inward, world_.skin(), farthest);
  const auto from_behind = [&](const Arrival& arrival) {
    return arrival.direction.dot(end->normal) < 0.0 && arrival.irradiance.maxCoeff() > 0.0;
  };
  const bool lit_from_behind =
      end && ((sky && from_behind(*sky)) ||
              std::any_of(sources_.begin(), sources_.end(), [&](const auto& source) {
                return from_behind(source->at(end->position));
              }));
  EyePath path(object, object_from_world * hit.position, object_from_world.rotation * inward,
               end ? end->distance : farthest, lit_from_behind);
  const std::optional<double> distance = path.drawn(u, v);
  if (!distance) return Colour::Zero();
  if (even && world_.blocked(hit.position, inward, *distance + world_.skin())) {
    return Colour::Zero();
  }
  Colour arriving_here = Colour::Zero();
  const Vector3d place = hit.position + *distance * inward;
  for (const auto& source : sources_) {
    arriving_here += arriving(hit.object, place, source->at(place));
  }
  if (sky) arriving_here += arriving(hit.object, place, *sky);
  return path.scattered_to_eye(*distance) / path.density(*distance) * arriving_here;
}

Colour SingleScattering::sky_through(const WorldHit& hit, const Vector3d& inward,
                                     const Environment& environment) const {
  const WorldObject& object = world_.objects()[hit.object];
  const double farthest = std::min(world_.diameter(), dark * longest_free_path(object));
  const auto end = world_.first_hit(hit.position, inward, world_.skin(), farthest);
  if (!end || end->object != hit.object) return Colour::Zero();
  const double eta = object.boundary.eta, cosine = std::min(1.0, end->normal.dot(inward));
  if (cosine <= 0.0) return Colour::Zero();  // rounding at an edge
  const double transmitted = 1.0 - fresnel_internal(eta, cosine);
  if (transmitted <= 0.0) return Colour::Zero();
  const Vector3d outward = forward::refracted(inward, -end->normal, eta);
  const Colour lamps = environment.of_lamps(outward);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (lamps.maxCoeff() <= 0.0 || world_.blocked(end->position, outward, infinity)) {
    return Colour::Zero();
  }
  const Rigid object_from_world = object.world_from_object.inverse();
  const Colour depth =
      optical_depth(object, object_from_world * hit.position, object_from_world * end->position);
  return eta * eta * transmitted * lamps * (-depth).exp();
}

Colour SingleScattering::emitted(const WorldHit& hit, const Vector3d& inward, double u,
                                 double v) const {
  const WorldObject& object = world_.objects()[hit.object];
  const double free_path = longest_free_path(object);
  const double farthest = std::min(world_.diameter(), dark * free_path);
  const auto end = world_.first_hit(hit.position, inward, world_.skin(), farthest);
  const Rigid object_from_world = object.world_from_object.inverse();
  EyePath path(object, object_from_world * hit.position, object_from_world.rotation * inward,
               end ? end->distance : farthest, end.has_value());
  const std::optional<double> distance = path.drawn(u, v);
  if (!distance) return Colour::Zero();
  return object.emission / (4.0 * std::numbers::pi) * path.arrives(*distance) /
         path.density(*distance);
}

}  // namespace kappamu::render
