// First collisions of collimated beams in the cells of a polygrid: refracted into the object
// (light_entry.h), marched from cell to cell to the surface that they meet next, once
// for all channels.
#pragma once

#include <span>
#include <vector>

#include "forward/object_model.h"
#include "forward/polygrid/cell_walk.h"
#include "forward/polygrid/surface_map.h"

namespace kappamu::forward::polygrid {

/// A channel of a light, and where its powers go.
struct ChannelBeams {
  std::span<const Beam> beams;
  std::span<const Coefficients> of_cell;
  std::vector<double>& load;  ///< [corner]
  ObjectBalance& balance;
};

/// Beams of a light's channels, up to most_channels of them, which are followed together.
class BeamWalks {
 public:
  static constexpr std::size_t most_channels = 4;

  enum class Steps { forgotten, kept };

  /// Keeps references. Where steps are kept, beams that come again, as when a
  /// medium is edited, are neither refracted nor walked again.
  BeamWalks(const Polygrid& grid, const SurfaceMap& map, Steps steps);

  /// Adds ∫ S N dV of a light's beams to the channels' loads; S = σs'/σt' of the power that
  /// collides in a step, at the mean place of its collisions, whose functions share it: sums are
  /// exact. When no more than `remainder` of a beam is left, the rest collides there. `problem`
  /// gives mesh, surface, rays and eta; `remainder` stays the same. Throws InputError where a beam
  /// meets the surface from inside.
  void add(const ObjectProblem& problem, std::span<const ChannelBeams> channels, double remainder);

  using OfChannels = std::array<double, most_channels>;
  struct CellOptics {
    OfChannels sigma_t{};    ///< σt' [1/mm]
    OfChannels scattered{};  ///< share of what collides
  };
  /// Of a beam in a cell: its middle there and how that moves along the beam [1/mm].
  struct Step {
    int cell = 0;
    float length = 0.0F;  ///< [mm]
    Eigen::Vector3f at, along;
  };
  /// What beams leave.
  struct Left {
    std::vector<double> load;   ///< [corner][most_channels]
    std::vector<char> touched;  ///< [block of corners] whether their loads are of it
    OfChannels entering{}, absorbed{}, unscattered{};
  };

 private:
  /// One path for all channels that have it.
  struct Walk {
    OfChannels power{};  ///< after Fresnel reflection [mm²]
    Eigen::Vector3d from, direction;
    double length = 0.0;  ///< [mm]
    double walked = 0.0;  ///< [mm]
    CellRay ray;          ///< there
    std::vector<Step> steps;
  };

  bool same(std::span<const ChannelBeams> channels) const;
  /// Cells whose coefficients are not those of optics_.
  std::vector<char> changed_cells(std::span<const ChannelBeams> channels) const;
  void renew_optics(std::span<const ChannelBeams> channels, const std::vector<char>& changed);
  /// Beams of the same place and direction in several channels become one walk: one beam of each.
  std::vector<const Beam*> join(std::span<const ChannelBeams> channels);
  void enter(const ObjectProblem& problem, double size, Beam beam, Walk& walk) const;
  Step next_step(Walk& walk) const;
  /// Adds what a beam leaves, times `sign`.
  void march(Walk& walk, double remainder, double sign, Left& left) const;
  /// Where `entering` are given they are entered first, [walk].
  void march_all(const ObjectProblem& problem, std::span<const Beam* const> entering,
                 double remainder);

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
