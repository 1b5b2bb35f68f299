#include "forward/grid/opencl/multigrid/stream_tiles.h"

#include <algorithm>

namespace kappamu::forward {

namespace {

constexpr int deepest = 32;        ///< cells of a tile along z
constexpr int narrowest = 16;      ///< and at least along x, if the grid has them
constexpr int shortest_march = 8;  ///< and along y

/// What rounding the halves of a ring's row up may take (make_split_ring), and to spare.
constexpr int row_slack = 4;

int parts(int whole, int part) {
  return (whole - 1) / part + 1;
}

/// Tiles whose ring of `depth` planes, reaching `halo` cells further on all sides, fits the cache.
StreamTiles cut(const StreamMachine& machine, const GridShape& grid, int depth, int halo) {
  StreamTiles tiles;
  const int nz = parts(grid.nz, deepest);
  tiles.size[2] = parts(grid.nz, nz);
  const int row = machine.cache_cells / (depth * (tiles.size[2] + 2 * halo)) - 2 * halo;
  const int nx = parts(grid.nx, std::max(row, narrowest));
  tiles.size[0] = parts(grid.nx, nx);
  // As few tiles along y, whose rings begin cold and whose rims are computed twice, as keep all
  // cores busy to the end.
  const int across = nx * nz;
  int along = parts(machine.cores, across);
  while (along * across % machine.cores != 0 && along * across < 4 * machine.cores) ++along;
  tiles.size[1] = parts(grid.ny, std::min(along, parts(grid.ny, shortest_march)));
  tiles.count =
      parts(grid.nx, tiles.size[0]) * parts(grid.ny, tiles.size[1]) * parts(grid.nz, tiles.size[2]);
  tiles.sums = parts(grid.nx, tiles.size[0]) * parts(grid.nz, tiles.size[2]) * grid.ny;
  tiles.scratch_cells = depth * (tiles.size[0] + 2 * halo + row_slack) * (tiles.size[2] + 2 * halo);
  return tiles;
}

}  // namespace

StreamTiles tiles_down(const StreamMachine& machine, const GridShape& fine, const GridShape& coarse,
                       const std::array<int, 3>& halving) {
  // Sized as on the fine grid, whose planes fill the cache, then rounded to whole coarse cells.
  constexpr int depth = 5, halo = 5;
  StreamTiles tiles = cut(machine, fine, depth, halo);
  for (std::size_t a = 0; a < 3; ++a) tiles.size[a] = parts(tiles.size[a], 1 + halving[a]);
  tiles.count = parts(coarse.nx, tiles.size[0]) * parts(coarse.ny, tiles.size[1]) *
                parts(coarse.nz, tiles.size[2]);
  constexpr int sum_planes = 4;
  const auto fine_extent = [&](std::size_t a) { return tiles.size[a] * (1 + halving[a]); };
  tiles.scratch_cells =
      depth * (fine_extent(0) + 2 * halo + row_slack) * (fine_extent(2) + 2 * halo) +
      sum_planes * (tiles.size[0] + 2) * (tiles.size[2] + 2);
  return tiles;
}

StreamTiles tiles_up(const StreamMachine& machine, const GridShape& fine, const GridShape& coarse) {
  StreamTiles tiles = cut(machine, fine, 6, 5);
  tiles.scratch_cells += coarse.nx;
  return tiles;
}

StreamTiles tiles_step(const StreamMachine& machine, const GridShape& grid) {
  // A ring of values and one, half as large, of what rounding left over of black ones.
  constexpr int depth = 4, halo = 3;
  StreamTiles tiles = cut(machine, grid, depth + depth / 2, halo);
  tiles.scratch_cells =
      depth * (tiles.size[0] + 2 * halo + row_slack + (tiles.size[0] + 2 * halo) / 2 + 2) *
      (tiles.size[2] + 2 * halo);
  return tiles;
}

StreamTiles tiles_residual(const StreamMachine& machine, const GridShape& grid) {
  // Vectors of doubles, twice as large as those of floats; and as much again for x, d and b, which
  // are read more than once. (256x256x20, 16 patterns: 31 ms, without the latter 37 to 42.)
  constexpr int depth = 4, halo = 3;
  return cut(machine, grid, 4 * depth, halo);
}

}  // namespace kappamu::forward
