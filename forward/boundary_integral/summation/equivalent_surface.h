// Far fields of boxes as charges on cubes about them: the kernel-independent fast multipole method
// (Ying, Biros, Zorin 2004) for G = e^−λr/(4πr).
//
// A box's sources act outside like charges on its inner cube, found from the potentials that both
// make on its outer cube; what comes from afar acts inside like charges on the outer cube, found
// from its potentials on the inner one. G is symmetric: each of the two maps is the other's
// transpose.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <vector>

namespace kappamu::forward::boundary_integral {

/// Widths of the inner and the outer cube over the box's. Points may reach out of their box as far
/// as the inner cube does (octree.h, box_reach).
inline constexpr double inner_cube = 1.2, outer_cube = 2.8;

/// The points of a cube's surface on a lattice of `order` points an edge, and the lattice's 48
/// symmetries.
class SurfaceLattice {
 public:
  explicit SurfaceLattice(int order);
  int size() const { return static_cast<int>(index_.size()); }
  /// (size, 3): points of a cube of half width `half` about the origin.
  Eigen::MatrixX3d points(double half) const;
  /// Where the point goes when axes are flipped (bits of `flips`), then axis k becomes what was
  /// axis order[k].
  std::vector<int> moved(int flips, const std::array<int, 3>& order) const;

 private:
  int order_;
  std::vector<std::array<int, 3>> index_;
};

/// How a box's neighbour at an offset of (2..3 in some axis) widths becomes one of 16 that are
/// turned into each other by the lattice's symmetries: offsets 3 ≥ x ≥ y ≥ z ≥ 0.
struct Translation {
  int kind = 0;      ///< 16x + 4y + z
  int symmetry = 0;  ///< number of the lattice symmetry that turns the offset into it
};

/// The maps of boxes of one width. Matrices are (size, size).
struct LevelMaps {
  Eigen::MatrixXd charges_from_check;                ///< outer potentials → inner charges
  std::array<Eigen::MatrixXd, 8> parent_from_child;  ///< inner charges → the parent's
  std::map<int, Eigen::MatrixXd> translation;  ///< by kind: charges → the target's potentials
};

class EquivalentSurfaces {
 public:
  /// `order` points along the cubes' edges; `decay` λ [1/mm].
  EquivalentSurfaces(int order, double decay);
  const SurfaceLattice& lattice() const { return lattice_; }
  /// Of boxes of `width` [mm]; `parent_from_child` is for their children.
  LevelMaps maps(double width) const;
  static Translation translation(const std::array<int, 3>& offset);
  /// The lattice's symmetry of that number: where each point goes.
  const std::vector<int>& symmetry(int number) const {
    return symmetries_[static_cast<std::size_t>(number)];
  }

 private:
  SurfaceLattice lattice_;
  double decay_;
  std::vector<std::vector<int>> symmetries_;
};

}  // namespace kappamu::forward::boundary_integral
