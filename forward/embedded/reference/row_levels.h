// The levels of one medium as sparse matrices: rows with their columns, for the reference solver.
#pragma once

#include <span>
#include <vector>

#include "forward/embedded/equations/levels.h"
#include "forward/embedded/reference/sparse_rows.h"

namespace kappamu::forward::embedded {

struct RowLevel {
  SparseRows<float> matrix;
  SparseRows<float> interpolation;  ///< rows: unknowns here; columns: of the next coarser level
  SparseRows<float> restriction;    ///< its transpose
};

struct RowLevels {
  std::span<const Level> from;
  const Eigen::MatrixXd& coarsest;  ///< inverse
  std::size_t channel;
  SparseRows<double> matrix;    ///< of the finest level
  std::vector<RowLevel> level;  ///< finest first; the coarsest is solved for directly
};

/// Those from `first` on. Keeps references to `levels`.
RowLevels make_row_levels(const Levels& levels, std::size_t channel, std::size_t first = 0);

}  // namespace kappamu::forward::embedded
