#include "render/live/sky_light.h"

#include <utility>

#include "forward/polygrid/closest_point.h"
#include "render/light/incident_light.h"

namespace kappamu::render {

using Eigen::Vector3d;

namespace {

std::optional<EnvironmentLight> environment_of(const std::vector<Light>& lights) {
  for (const Light& light : lights) {
    if (const auto* environment = std::get_if<EnvironmentLight>(&light)) return *environment;
  }
  return std::nullopt;
}

/// Beams of a shape with other vertices, each at the same place of its triangle. One that would
/// meet it from inside now is left out.
BeamsOfChannels carried(const BeamsOfChannels& beams, const std::vector<Vector3d>& from,
                        const WorldObject& object) {
  BeamsOfChannels result;
  for (std::size_t c = 0; c < beams.size(); ++c) {
    result[c].reserve(beams[c].size());
    for (forward::Beam beam : beams[c]) {
      const auto t = static_cast<std::size_t>(beam.triangle);
      if (beam.direction.dot(object.surface.normal[t]) >= 0.0) continue;
      const auto corner = [&](const std::vector<Vector3d>& of, std::size_t i) -> const Vector3d& {
        return of[static_cast<std::size_t>(object.mesh.triangles[t][i])];
      };
      const Vector3d weights = forward::closest_weights(beam.position, corner(from, 0),
                                                        corner(from, 1), corner(from, 2));
      beam.position = Vector3d::Zero();
      for (std::size_t i = 0; i < 3; ++i) {
        beam.position += weights[static_cast<Eigen::Index>(i)] * corner(object.mesh.vertices, i);
      }
      result[c].push_back(beam);
    }
  }
  return result;
}

}  // namespace

bool SkyLight::is_preview() const {
  return environment_ && rays_ < environment_rays;
}

void SkyLight::find(const World& world, const std::vector<Light>& lights, double rays,
                    std::uint64_t seed, Progress& progress) {
  const std::optional<EnvironmentLight> light = environment_of(lights);
  const bool as_before =
      light && light_ ? same(*light, *light_) : light.has_value() == light_.has_value();
  if (as_before && (rays_ >= rays || !environment_)) return;
  if (!as_before) {
    environment_ = make_environment(lights, LampsEnter::as_beams);
    light_ = light;
    rays_ = 0.0;
  }
  std::vector<Found> found(of_.size());
  for (std::size_t i = 0; environment_ && i < found.size(); ++i) {
    found[i].diffuse = diffuse_light(world, i, *environment_, seed, progress, rays).irradiance;
  }
  of_ = std::move(found);
  rays_ = rays;
  seed_ = seed;
}

BeamsOfChannels SkyLight::lamps(const World& world, std::size_t object,
                                std::span<const BeamPlace> places, bool moves, Progress& progress) {
  if (!environment_ || !environment_->has_beams()) return {};
  Found& found = of_[object];
  const WorldObject& lit = world.objects()[object];
  if (moves && !found.beams.empty()) {
    return carried(found.beams.begin()->second, found.vertices, lit);
  }
  const auto kept = found.beams.find(places.size());
  if (kept != found.beams.end()) return kept->second;
  BeamsOfChannels beams =
      beams_of_lights(world, object, {}, &*environment_, places, seed_, progress, rays_);
  found.vertices = lit.mesh.vertices;
  return found.beams[places.size()] = std::move(beams);
}

}  // namespace kappamu::render
