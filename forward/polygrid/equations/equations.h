// The equations of diffusion on a polygrid: the weak form of ∇·(κ∇φ) − μφ = −S with φ + 2Aκ ∂φ/∂n =
// q, for φ at the corners of the cells,
//   Σ_cells κ a(φ, v) + μ (φ, v) + Σ_boundary sides (φ, v)/(2A) = load(v),
// symmetric positive definite; tested with v = 1 it is the balance of power, which therefore holds
// for every solution. κ and μ are constant in each cell.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/object_medium.h"
#include "forward/polygrid/equations/cell_integrals.h"
#include "forward/polygrid/polygrid.h"

namespace kappamu::forward::polygrid {

/// Of a symmetric matrix: the columns of each row from the diagonal on, sorted; of links those
/// beyond it.
struct Pattern {
  std::vector<int> start{0};  ///< of each row, and the end of the last
  std::vector<int> column;

  std::size_t rows() const { return start.size() - 1; }
};

/// The numbers of one medium.
struct MediumValues {
  std::vector<double> value;  ///< of the matrix, by Equations::matrix [mm²]
  std::vector<double> link;   ///< conductances of the seven-point form, by Equations::links [mm²]
  std::vector<double> leak;  ///< [unknown] sums of the matrix's rows: absorption and boundary [mm²]
  std::vector<double> absorption;  ///< [unknown] what a unit of φ there absorbs, Σ μ ∫ N dV [mm²]
};

class Equations {
 public:
  /// A of the boundary condition. Throws InputError where a cell is inverted.
  Equations(const Polygrid& grid, double A);

  std::size_t unknowns() const { return matrix_.rows(); }
  const Pattern& matrix() const { return matrix_; }
  const Pattern& links() const { return links_; }  ///< along edges of cells
  /// [unknown] the lattice place of a corner, for aggregates; different corners may share one.
  const std::vector<Eigen::Vector3i>& place() const { return place_; }

  /// `of_cell`: coefficients of each cell.
  MediumValues values(std::span<const Coefficients> of_cell) const;
  /// Makes the values of some rows anew, all those about cells whose coefficients have changed.
  void renew(std::span<const Coefficients> of_cell, std::span<const int> rows,
             MediumValues& values) const;
  double volume(std::size_t cell) const { return integrals_[cell].volume; }  ///< [mm³]
  /// ∫ N dA of every corner's function over the boundary [mm²]; zero inside.
  const std::vector<double>& boundary_share() const { return boundary_share_; }

 private:
  void make_row(std::size_t row, std::span<const Coefficients> of_cell, MediumValues& values) const;

  double A_;
  std::vector<CellIntegrals> integrals_;
  Pattern matrix_, links_;
  std::vector<Eigen::Vector3i> place_;
  std::vector<int> slot_start_, slot_;  ///< [unknown] 8·cell + corner of the cells about it
  /// Where in their row of matrix_ and links_ the corners of a slot's cell lie; `elsewhere` for
  /// those before the row's.
  static constexpr std::uint8_t elsewhere = 255;
  std::vector<std::array<std::uint8_t, 8>> in_row_;
  std::vector<std::array<std::uint8_t, 3>> in_links_;
  std::vector<double> boundary_;  ///< of the matrix: its part from the boundary condition [mm²]
  std::vector<double> boundary_share_;
};

}  // namespace kappamu::forward::polygrid
