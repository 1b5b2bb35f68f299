#include "render/picture/single_scattering.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace

Vector3d refracted_in(const Vector3d& direction, const Vector3d& normal, double eta) {
  const double cos_outside = -direction.dot(normal);
  const double cos_inside = std::sqrt(1.0 - (1.0 - cos_outside * cos_outside) / (eta * eta));
  return (direction / eta + (cos_outside / eta - cos_inside) * normal).normalized();
}

Colour SingleScattering::optical_depth(const WorldObject& object, const Vector3d& from,
                                       const Vector3d& to) const {
  const double length = (to - from).norm();
  const auto voxel = object.media.channels[0]->voxel_mm();
  // Piecewise constant voxels, at the middles of steps of half a voxel.
  constexpr double most_steps = 4096.0;
  const int steps =
      voxel ? static_cast<int>(std::clamp(std::ceil(2.0 * length / *voxel), 1.0, most_steps)) : 1;
  Colour sum = Colour::Zero();
  for (int i = 0; i < steps; ++i) {
    sum += scattering_at(object, from + (i + 0.5) / steps * (to - from)).extinction;
  }
  return sum * (length / steps);
}

Colour SingleScattering::arriving(std::size_t object_index, const Vector3d& point,
                                  const LightSource& source) const {
  const Arrival arrival = source.at(point);
  if (arrival.irradiance.maxCoeff() <= 0.0) return Colour::Zero();
  const WorldObject& object = world_.objects()[object_index];
  double free_path = 0.0;  // the longest of all channels [mm]
  for (const auto& medium : object.media.channels) {
    free_path = std::max(free_path, 3.0 * medium->largest().kappa);
  }
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
                                         double v) const {
  const WorldObject& object = world_.objects()[hit.object];
  const Rigid object_from_world = object.world_from_object.inverse();
  const Vector3d start = object_from_world * hit.position;
  // Depths are drawn by the extinction at the surface, of a channel picked by chance.
  const Colour rate =
      scattering_at(object, start - world_.skin() * (object_from_world.rotation * hit.normal))
          .extinction;
  const double which = 3.0 * u;
  const int channel = std::min(2, static_cast<int>(which));
  const double depth = -std::log(std::max(1e-300, 1.0 - v)) / rate[channel];
  const double density = (rate * (-rate * depth).exp()).mean();
  const Vector3d point = hit.position + depth * inward;
  if (world_.blocked(hit.position, inward, depth + world_.skin())) return Colour::Zero();

  const Vector3d in_object = object_from_world * point;
  const Scattering here = scattering_at(object, in_object);
  Colour arriving_here = Colour::Zero();
  for (const auto& source : sources_) arriving_here += arriving(hit.object, point, *source);
  return here.scattering / (4.0 * std::numbers::pi) * arriving_here *
         (-optical_depth(object, start, in_object)).exp() / density;
}

}  // namespace kappamu::render
