// How the sweeps of grid_stream_cycle.cl, grid_stream_step.cl and grid_reduced.cl cut a grid into
// tiles.
#pragma once

#include <array>
#include <cstddef>

#include "core/grid.h"

namespace kappamu::forward {

struct StreamTiles {
  std::array<int, 3> size;  ///< cells of a tile along x, y, z
  int count = 1;
  int sums = 1;           ///< planes y of all tiles along x and z: each has sums of its own
  int scratch_cells = 0;  ///< vectors of scratch memory each tile's item needs
};

/// What limits the tiles: how many cores they keep busy, how many vectors fit a core's cache. The
/// former decides on cuts along y alone, of which no sum depends (grid_stream_prelude.cl).
struct StreamMachine {
  int cores = 2;
  int cache_cells = 8192;
};

/// The way down from `fine`, halved along the axes with halving 1; the tiles are of coarse cells.
StreamTiles tiles_down(const StreamMachine& machine, const GridShape& fine, const GridShape& coarse,
                       const std::array<int, 3>& halving);
/// The way up to `fine`, with or without the sums of the finest level.
StreamTiles tiles_up(const StreamMachine& machine, const GridShape& fine, const GridShape& coarse);
/// The step of conjugate gradients.
StreamTiles tiles_step(const StreamMachine& machine, const GridShape& grid);
/// The true residual.
StreamTiles tiles_residual(const StreamMachine& machine, const GridShape& grid);

}  // namespace kappamu::forward
