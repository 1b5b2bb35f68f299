// The grid's equations (forward/grid/grid_solver.h) on PETSc, each rank with its piece of the
// block: assembled on a DMDA, solved by conjugate gradients with algebraic multigrid
// (docs/distributed.md).
//
// To its rank a piece is a block like any other: setup() is that of the piece, halo included, and
// so are all arrays. Coefficients and directions come with the halo filled
// (BlockPieces::exchange). Light on pixels of the halo is not used; exitance, sums and products of
// what another rank owns are 0, so that sums over ranks count everything once.
#pragma once

#include <memory>
#include <vector>

#include "forward/distributed/block_pieces.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward::distributed {

/// What PETSc's database says under `-kappamu_` (such as -kappamu_pc_type) prevails. Every call of
/// the solver is collective but setup(), constants() and backend().
std::unique_ptr<GridSolver> make_distributed_solver(std::shared_ptr<const BlockPieces> pieces);

/// Makes operators of those pieces alone, of the one that a setup has the shape of. A device is not
/// asked for, numbers are double.
std::shared_ptr<const OperatorFactory> distributed_operators(
    std::vector<std::shared_ptr<const BlockPieces>> pieces);

}  // namespace kappamu::forward::distributed
