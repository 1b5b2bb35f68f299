// First collisions of collimated beams in the cells of a polygrid, marched once for all channels
// (forward/light/first_collisions.h).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "forward/light/first_collisions.h"
#include "forward/polygrid/cell_walk.h"
#include "forward/polygrid/surface_map.h"

namespace kappamu::forward::polygrid {

/// A channel of a light, and where its powers go.
struct ChannelBeams {
  std::span<const Beam> beams;
  std::span<const Coefficients> of_cell;
  std::vector<double>& load;  ///< [corner]
  ObjectBalance& balance;
  std::vector<Beam>* leaving = nullptr;  ///< unscattered, where that is asked for
};

/// Beams of a light's channels, up to most_channels of them, which are followed together.
class BeamWalks {
 public:
  static constexpr std::size_t most_channels = beam_lanes;

  enum class Steps { forgotten, kept };

  /// Keeps references. Where steps are kept, beams that come again, as when a
  /// medium is edited or another light turns, are neither refracted nor walked again.
  BeamWalks(const Polygrid& grid, const SurfaceMap& map, Steps steps);

  /// Adds ∫ S N dV of a light's beams to the channels' loads. When no more than `remainder` of a
  /// beam is left, the rest collides there. `problem` gives mesh, surface, rays and eta, which stay
  /// the same, as does `remainder`. Throws InputError where a beam that begins outside meets the
  /// surface from inside. What leaves is listed only where steps are forgotten.
  void add(const ObjectProblem& problem, std::span<const ChannelBeams> channels, double remainder);

  /// What beams leave.
  struct Left {
    std::vector<double> load;   ///< [corner][most_channels]
    std::vector<char> touched;  ///< [block of corners] whether their loads are of it
    OfChannels entering{}, absorbed{}, unscattered{};
    std::array<std::vector<Beam>, most_channels> leaving;
  };

 private:
  /// One path for all channels that have it.
  struct Walk {
    Beam beam;           ///< that the path is of
    OfChannels power{};  ///< before Fresnel reflection [mm²]
    std::optional<BeamPath> path;
    PathPlace place;
    CellRay ray;  ///< there
    std::vector<CellStep> steps;
  };
  class Cells;
  class Marched;

  bool same(std::span<const ChannelBeams> channels) const;
  /// Cells whose coefficients are not those of optics_.
  std::vector<char> changed_cells(std::span<const ChannelBeams> channels) const;
  void renew_optics(std::span<const ChannelBeams> channels, const std::vector<char>& changed);
  /// Beams of the same place and direction in several channels become one walk: one beam of each.
  std::vector<const Beam*> join(std::span<const ChannelBeams> channels);
  void enter(const Walls& walls, const Beam& beam, Walk& walk) const;
  /// Adds what a beam leaves, times `sign`.
  void follow(const Walls& walls, Walk& walk, double remainder, double sign, Left& left) const;
  /// Where `entering` are given they are entered first, [walk], unless the walk is of that path.
  void march_all(const Walls& walls, std::span<const Beam* const> entering, double remainder);

  const Polygrid& grid_;
  const SurfaceMap& map_;
  bool keep_;
  std::vector<std::vector<Beam>> beams_;          ///< [channel] that the walks are of
  std::vector<std::vector<Coefficients>> media_;  ///< [channel][cell] that optics_ are of
  std::vector<CellOptics> optics_;
  std::vector<Walk> walks_;
  Left left_;                ///< by all beams
  std::vector<Left> parts_;  ///< room for parts of the beams; loads are zero
};

}  // namespace kappamu::forward::polygrid
