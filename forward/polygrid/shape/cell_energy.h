// Energy of the shape of a polygrid's cells, and its gradient: finite only where no cell's corner
// is inverted or, with ε > 0, everywhere (Garanzha et al. 2021, Foldover-free maps in 50 lines of
// code).
//
// Per corner of a cell, J holds the three edges there over their lengths in a target cell, s =
// |J|², d = det J, χ = (d + √(ε² + d²))/2:
//     (s/3)^1.5 / χ  +  size_weight · (d² + 1)/(2χ)
// The first term is 1 for a right angle and equal edges, the second for the target's volume.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace kappamu::forward {

struct TargetCell {
  Eigen::Array3d inverse_edge{1.0, 1.0, 1.0};  ///< along the cell's own axes [1/mm]
};

struct CellEnergy {
  double size_weight = 0.2;
  double epsilon = 0.0;
  int power = 1;  ///< of the energy of a corner: larger ones look at the worst cells
};

/// Of all cells of a grid. Equal input gives equal bits on any number of cores.
class CellEnergies {
 public:
  /// Keeps references. `corners`: of the grid.
  CellEnergies(const std::vector<std::array<int, 8>>& cells, const std::vector<TargetCell>& targets,
               std::size_t corners);

  /// Sum over the cells' corners, and its gradient [1/mm] per corner of the grid. Infinite where ε
  /// is 0 and a corner is inverted; the gradient is not to be used then.
  double operator()(const CellEnergy& energy, const std::vector<Eigen::Vector3d>& corner,
                    std::vector<Eigen::Vector3d>& gradient);
  /// Least d of all corners of cells.
  double least_determinant(const std::vector<Eigen::Vector3d>& corner) const;

  /// By corner of a cell, its derivatives by the corner's x, y and z.
  using Slopes = std::array<std::array<double, 8>, 3>;

 private:
  const std::vector<std::array<int, 8>>& cells_;
  const std::vector<TargetCell>& targets_;
  std::vector<int> slot_start_, slot_;  ///< [corner] 8·cell + corner of the cells about it
  std::vector<Slopes> slopes_;          ///< [cell]
};

}  // namespace kappamu::forward
