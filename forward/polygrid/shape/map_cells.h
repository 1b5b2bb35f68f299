// The map of a layered lattice into an object: outer corners on its surface, cells near cubes.
//
// Each round finds the closest surface point of every outer corner, and the outer corner closest to
// every part of the surface that is left away; both draw the corner to a plane there, along which
// it slides freely, while the cells' energy (cell_energy.h) is minimised. Cells are never inverted
// once none is.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "forward/polygrid/closest_point.h"
#include "forward/polygrid/shape/layered_lattice.h"

namespace kappamu::forward {

/// Thickness of the layer in its target cells, over the others' edge.
inline constexpr double layer_thickness = 0.7;

struct MapEffort {
  int rounds = 10;
  /// Weight of squared distances from the surface (in edges of a cell) against the energy of a
  /// cell's corner, from the first round to the last.
  double first_pull = 10.0, last_pull = 30.0;
  int power = 1;              ///< CellEnergy's
  bool onto_surface = false;  ///< at last, corners go exactly onto it where cells admit it
};

/// `surface` is that of the object, `samples` are points all over it [mm], `volume` is its [mm³].
struct MapTarget {
  const ClosestPoint& surface;
  std::vector<Eigen::Vector3d> samples;
  double volume = 0.0;
};

/// Moves the corners of `lattice`. False: cells are still inverted. `report` is called all along
/// and may throw Cancelled.
bool map_cells(LayeredLattice& lattice, const MapTarget& target, const MapEffort& effort,
               const std::function<void()>& report);

}  // namespace kappamu::forward
