// The linear systems of the baselines, assembled on the host in double: seven-point stencils on
// bricks, whose edges may differ where a grid of odd extent was coarsened.
//
// (A x)_i = Σ_j G_ij (x_i − x_j) + Σ_b G_b x_i + S_i x_i = b_i, a balance of power in every cell.
#pragma once

#include <array>
#include <vector>

#include "core/grid.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::studies::baseline {

using namespace forward;

/// Cells of a grid level; `width[axis][i]` [mm] is the edge of cell i along the axis.
struct Bricks {
  std::array<std::vector<double>, 3> width;
  int extent(int axis) const {
    return static_cast<int>(width[static_cast<std::size_t>(axis)].size());
  }
  std::size_t cells() const { return width[0].size() * width[1].size() * width[2].size(); }
};

Bricks bricks_of(const GridShape& shape);

/// Pairs of cells along every axis longer than one, the odd last cell alone.
Bricks coarsened(const Bricks& fine);

/// [W] 5.3: a coarse node's property is the mean over its (existing) children, weighted by volume.
std::vector<double> children_mean(const Bricks& fine, const Bricks& coarse,
                                  const std::vector<double>& values);

struct Stencil {
  std::array<int, 3> n{};
  /// G of the faces across each axis, boundary faces included (0 on mirrors): [nz][ny][nx+1],
  /// [nz][ny+1][nx], [nz+1][ny][nx].
  std::array<std::vector<double>, 3> face;
  std::vector<double> sink;     ///< S, [z][y][x]
  std::vector<double> inverse;  ///< 1 / (Σ G + S), [z][y][x]
};

/// Our discretisation of ∇·(κ∇φ) − μφ (grid_solver.h), x = φ: G = area / (w_i/(2κ_i) +
/// w_j/(2κ_j)), G_b = area / (w_i/(2κ_i) + 2A), S = μ · volume.
Stencil conservative_stencil(const GridSetup& setup, double robin_A, const Bricks& bricks,
                             const std::vector<double>& kappa, const std::vector<double>& mu);

/// [W] equation (8), Σ_j κ_jφ_j/h² − 6κ_iφ_i/h² − μ_iφ_i = 0, in the variable x = κφ that [W] 5.2
/// stores: G = h, G_b = (the conservative one)/κ_i, S = μ_i h³/κ_i, for cubic cells. A surface node
/// v'_i has the κ of its voxel, at d = h/2. Equals the conservative one for constant κ.
Stencil wang2008_stencil(const GridSetup& setup, double robin_A, const std::vector<double>& kappa,
                         const std::vector<double>& mu);

}  // namespace kappamu::studies::baseline
