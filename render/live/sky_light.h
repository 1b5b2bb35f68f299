// What the environment of a live scene sends to its objects: even light, and beams of its lamps.
// Both are kept while environment and shapes stay, and stay as they were while shapes move.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/progress.h"
#include "render/light/beam_places.h"
#include "render/light/environment.h"
#include "render/scene/world.h"

namespace kappamu::render {

class SkyLight {
 public:
  using Irradiance = std::array<std::vector<double>, 3>;  ///< R, G, B, per triangle

  explicit SkyLight(std::size_t objects) : of_(objects) {}

  /// Of the environment of these lights from now on, by `rays` at least (incident_light.h). Throws
  /// InputError where its image cannot be read.
  void find(const World& world, const std::vector<Light>& lights, double rays, std::uint64_t seed,
            Progress& progress);
  /// Shapes have come to rest: all is to be found again.
  void reset() { rays_ = 0.0; }

  /// None where the scene has none, or a dark one.
  const Environment* environment() const { return environment_ ? &*environment_ : nullptr; }
  /// Found by fewer rays than a picture at rest has.
  bool is_preview() const;
  /// Empty: there is none.
  const Irradiance& diffuse(std::size_t object) const { return of_[object].diffuse; }
  /// Of the lamps, at these places; those of a shape that `moves`, where the surface has taken
  /// them.
  BeamsOfChannels lamps(const World& world, std::size_t object, std::span<const BeamPlace> places,
                        bool moves, Progress& progress);

 private:
  /// Of an object.
  struct Found {
    Irradiance diffuse;
    std::map<std::size_t, BeamsOfChannels> beams;  ///< by the number of their places
    std::vector<Eigen::Vector3d> vertices;         ///< of the shape that they are of
  };

  std::optional<EnvironmentLight> light_;
  std::optional<Environment> environment_;
  double rays_ = 0.0;
  std::uint64_t seed_ = 1;
  std::vector<Found> of_;
};

}  // namespace kappamu::render
