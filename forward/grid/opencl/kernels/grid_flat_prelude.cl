// Kernels that go over the whole grid, one cell of one colour per item, for devices with very many
// items in flight: what grid_flat_cycle.cl, grid_flat_step.cl and grid_flat_residual.cl begin with.
// The algorithm is that of the sweeps (grid_stream_prelude.cl), stage by stage.
//
// Vectors are held by colour: of each row of the grid (nx + 1) >> 1 places, red cells of all rows
// first, then black ones, [colour][z][y][place][GROUPS]; the place of cell x is x >> 1.
// Neighbouring items are the GROUPS of a cell, then its neighbours of the same colour: memory is
// read in whole lines, and a cell's stencil once for all patterns.
#define WORKGROUP 256
#define FLAT kernel __attribute__((reqd_work_group_size(WORKGROUP, 1, 1)))

// Goes over the cells of one colour; a place's vector is at [AT(place)]. Items follow each other in
// tiles of 8 × 4 × 2 places, so that a work-group's neighbours are mostly its own: half of what
// rows would fetch from the cache that all share. A tile may reach beyond the grid
// (LaneKernels::tiled).
#define AT(place) ((size_t)(place)*GROUPS + group)
#define FOR_PLACES                                                                          \
  const int group = (int)get_global_id(0) % GROUPS, pairs = HALF, places = pairs * ny * nz; \
  const int tiles_x = (pairs + 7) >> 3, tiles_y = (ny + 3) >> 2, tiles_z = (nz + 1) >> 1;   \
  for (int slot = (int)get_global_id(0) / GROUPS; slot < tiles_x * tiles_y * tiles_z * 64;  \
       slot += (int)get_global_size(0) / GROUPS)
#define PLACE(colour)                                                                \
  const int tile = slot >> 6, tile_yz = tile / tiles_x;                              \
  const int y = ((tile_yz % tiles_y) << 2) + (slot >> 3 & 3),                        \
            z = ((tile_yz / tiles_y) << 1) + (slot >> 5 & 1);                        \
  const int parity = PARITY(colour, y, z), e = ((tile % tiles_x) << 3) + (slot & 7); \
  const int x = 2 * e + parity;                                                      \
  if (x >= nx || y >= ny || z >= nz) continue;                                       \
  const int row = z * ny + y, place = row * pairs + e, cell = row * nx + x;
#define STENCIL stencils[STENCIL_ROW(y, z, parity) + (x >> 1)]

// Σ G φ_neighbour of a cell, and (A φ) of it in flux form, from its neighbours' values.
typedef struct {
  vec west, east, south, north, down, up;
} Neighbours;
INLINE vec inflow(Stencil g, Neighbours at) {
  return g.west * at.west + g.east * at.east + g.south * at.south + g.north * at.north +
         g.down * at.down + g.up * at.up;
}
INLINE vec image(Stencil g, vec here, Neighbours at) {
  return g.west * (here - at.west) + g.east * (here - at.east) + g.south * (here - at.south) +
         g.north * (here - at.north) + g.down * (here - at.down) + g.up * (here - at.up) +
         g.sink * here;
}

// The neighbours of a cell of a grid of nx × ny × nz, VALUE(place, cell) being one's, `zero`
// outside.
#define NEIGHBOURS_OR(zero, VALUE)                                      \
  {                                                                     \
    x > 0 ? VALUE(place - 1 + parity, cell - 1) : (zero),               \
        x + 1 < nx ? VALUE(place + parity, cell + 1) : (zero),          \
        y > 0 ? VALUE(place - pairs, cell - nx) : (zero),               \
        y + 1 < ny ? VALUE(place + pairs, cell + nx) : (zero),          \
        z > 0 ? VALUE(place - pairs * ny, cell - nx * ny) : (zero),     \
        z + 1 < nz ? VALUE(place + pairs * ny, cell + nx * ny) : (zero) \
  }
#define NEIGHBOURS(VALUE) NEIGHBOURS_OR((vec)(0), VALUE)

// A kernel that leaves a sum begins with SUM and ends with LEAVE_SUM: partial [work-group][GROUPS]
// (sum_partials in grid_vectors.cl), in an order that never changes.
#define SUM(sum)                     \
  local accu_vec scratch[WORKGROUP]; \
  accu_vec sum = (accu_vec)(0)
#define LEAVE_SUM(sum, partial)                                                  \
  {                                                                              \
    const int item = (int)get_local_id(0);                                       \
    scratch[item] = sum;                                                         \
    for (int span = WORKGROUP / 2; span >= GROUPS; span /= 2) {                  \
      barrier(CLK_LOCAL_MEM_FENCE);                                              \
      if (item < span) scratch[item] += scratch[item + span];                    \
    }                                                                            \
    if (item < GROUPS) partial[get_group_id(0) * GROUPS + item] = scratch[item]; \
    barrier(CLK_LOCAL_MEM_FENCE);                                                \
  }
