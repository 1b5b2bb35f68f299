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

class BeamWalks {
 public:
  /// Keeps references. `keep`: steps are remembered, so that beams that come again, as when a
  /// medium is edited, are neither refracted nor walked again.
  BeamWalks(const Polygrid& grid, const SurfaceMap& map, bool keep);

  /// Adds ∫ S N dV of a light's beams to the channels' loads; S = σs'/σt' of the power that
  /// collides in a step, at the mean place of its collisions, whose functions share it: sums are
  /// exact. When no more than `remainder` of a beam is left, the rest collides there. `problem`
  /// gives mesh, surface, rays and eta; `remainder` stays the same. Throws InputError where a beam
  /// meets the surface from inside.
  void add(const ObjectProblem& problem, std::span<const ChannelBeams> channels, double remainder);

 private:
  /// Of a beam: a step's cell, its middle there and how that moves along the beam [1/mm].
  struct Step {
    int cell = 0;
    float length = 0.0F;  ///< [mm]
    Eigen::Vector3f at, along;
  };
  /// One path for all channels that have it.
  struct Walk {
    Eigen::Vector3d from, direction;
    double length = 0.0;  ///< [mm]
    double walked = 0.0;  ///< [mm]
    CellRay ray;          ///< there
    std::vector<Step> steps;
  };

  bool same(std::span<const ChannelBeams> channels) const;
  /// Beams of the same place and direction in several channels become one walk.
  void enter_all(const ObjectProblem& problem, std::span<const ChannelBeams> channels);
  Step next_step(Walk& walk) const;
  using OfCell = std::vector<std::span<const Coefficients>>;  ///< [channel][cell]
  /// Adds a beam's loads and powers, times `sign`, to [corner][channel] and to the channels'
  /// balances.
  void march(Walk& walk, const double* power, const OfCell& of_cell, double remainder, double sign,
             std::vector<double>& load, std::span<ObjectBalance> balance) const;
  void march_all(const OfCell& of_cell, double remainder);
  /// Takes away and adds again what beams through cells of other coefficients have left.
  void march_changed(const OfCell& of_cell, double remainder);

  const Polygrid& grid_;
  const SurfaceMap& map_;
  bool keep_;
  std::vector<std::vector<Beam>> beams_;  ///< [channel] that the walks are of
  std::vector<Walk> walks_;
  std::vector<double> power_;           ///< [walk][channel] after Fresnel reflection [mm²]
  std::vector<double> load_;            ///< [corner][channel] of all beams
  std::vector<ObjectBalance> balance_;  ///< [channel]
  std::vector<std::vector<Coefficients>> media_;  ///< [channel][cell] that these are of
};

}  // namespace kappamu::forward::polygrid
