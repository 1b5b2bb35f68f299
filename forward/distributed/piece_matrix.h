// The matrix of the grid's equations (forward/grid/grid_solver.h), the rows of each rank's voxels
// assembled by that rank.
#pragma once

#include <span>

#include "forward/distributed/block_pieces.h"

namespace kappamu::forward::distributed {

/// With room for the seven values of a row and none in them.
Matrix make_matrix(const BlockPieces& pieces);

/// Sets A for κ [mm] and μ [1/mm] of the piece, halo filled; `A` of the boundary condition.
void assemble(const BlockPieces& pieces, double A, std::span<const double> kappa,
              std::span<const double> mu, Mat matrix);

}  // namespace kappamu::forward::distributed
