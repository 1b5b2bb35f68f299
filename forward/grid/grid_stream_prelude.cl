// Sweeps through the grid that keep intermediate planes in the cache, for devices with few fast
// cores and large caches: what grid_stream_cycle.cl and grid_stream_step.cl begin with. Theory,
// traffic and measurements: docs/engine.md.
//
// Unknowns are the red cells, (x+y+z) even: black ones are eliminated exactly, φ_b = (b_b + Σ G
// φ_r) / D, which leaves S = A_rr − A_rb D⁻¹ A_br (reduced system; Elman & Golub 1990). The
// smoother is damped Jacobi on S with S's own diagonal, `smoother` = ω / S_ii on red cells, and
// holds 1 / D on black ones. On the finest level the vectors of conjugate gradients hold red cells
// only, in their order: cell x of row (y, z) is element x >> 1 of a row of (nx + 1) >> 1.
//
// One work-item owns a tile of the grid and marches through it along y. What one stage of the
// computation leaves for the next lives in a ring of the last few planes (x, z), small enough for
// the cache, and every stage runs one plane behind the one it depends on:
//
//        plane t      red cells          from the right-hand side
//        plane t − 1  black cells        from red ones of t − 2, t − 1, t
//        plane t − 2  residual on red    from black ones of t − 3, t − 2, t − 1
//
// Around its tile an item computes as many cells once more as the stages need (they are its
// neighbours' too); it writes only its own. So no value depends on how items are scheduled.
//
#if GROUPS != 1
#error "streams hold all lanes of a cell in one vector"
#endif

// Helpers must be inlined: only then does the compiler use vectors of full width everywhere.
#define INLINE inline __attribute__((always_inline))

typedef struct {
  int x0, x1, y0, y1, z0, z1;
} Box;

// `box` and what lies up to `more` cells around it inside the grid.
INLINE Box around(Box box, int more, int nx, int ny, int nz) {
  const Box result = {max(box.x0 - more, 0),  min(box.x1 + more, nx), max(box.y0 - more, 0),
                      min(box.y1 + more, ny), max(box.z0 - more, 0),  min(box.z1 + more, nz)};
  return result;
}

// A ring of planes: cell (x, y, z) is at [y mod depth][z − z0 + 1][x − x0 + 1]; the rows and
// columns on its rim stay zero, being outside the grid wherever they are read.
#ifndef RING_VEC
#define RING_VEC vec
#endif
typedef RING_VEC ring_vec;
typedef struct {
  global ring_vec* planes;
  int depth, row, plane, x0, z0;
} Ring;

INLINE Ring make_ring(global ring_vec* memory, int depth, Box box) {
  Ring ring;
  ring.planes = memory;
  ring.depth = depth;
  ring.row = box.x1 - box.x0 + 2;
  ring.plane = ring.row * (box.z1 - box.z0 + 2);
  ring.x0 = box.x0 - 1;
  ring.z0 = box.z0 - 1;
  return ring;
}

INLINE void clear(global ring_vec* values, int count) {
  for (int i = 0; i < count; ++i) values[i] = (ring_vec)(0);
}

// Pointer p such that p[x] is cell (x, y, z).
INLINE global ring_vec* ring_row(Ring ring, int y, int z) {
  return ring.planes + ((y + ring.depth) % ring.depth) * ring.plane + (z - ring.z0) * ring.row -
         ring.x0;
}

typedef struct {
  global const REAL *gx, *gy, *gy_north, *gz, *gz_up;
} Conductances;
INLINE Conductances conductances_at(global const REAL* gx, global const REAL* gy,
                                    global const REAL* gz, int nx, int ny, int y, int z) {
  Conductances g;
  g.gx = gx + ((size_t)z * ny + y) * (nx + 1);
  g.gy = gy + ((size_t)z * (ny + 1) + y) * nx;
  g.gy_north = g.gy + nx;
  g.gz = gz + ((size_t)z * ny + y) * nx;
  g.gz_up = g.gz + (size_t)nx * ny;
  return g;
}

typedef struct {
  global const ring_vec *here, *south, *north, *down, *up;
} Rows;
INLINE Rows rows_at(Ring ring, int y, int z) {
  Rows rows;
  rows.here = ring_row(ring, y, z);
  rows.south = ring_row(ring, y - 1, z);
  rows.north = ring_row(ring, y + 1, z);
  rows.down = rows.here - ring.row;
  rows.up = rows.here + ring.row;
  return rows;
}

// Σ G φ_neighbour
#define INFLOW(g, v, x)                                                                           \
  ((g).gx[x] * (v).here[(x)-1] + (g).gx[(x) + 1] * (v).here[(x) + 1] + (g).gy[x] * (v).south[x] + \
   (g).gy_north[x] * (v).north[x] + (g).gz[x] * (v).down[x] + (g).gz_up[x] * (v).up[x])

// Σ G (φ − φ_neighbour)
#define OUTFLOW(g, v, x)                                                                       \
  ((g).gx[x] * ((v).here[x] - (v).here[(x)-1]) +                                               \
   (g).gx[(x) + 1] * ((v).here[x] - (v).here[(x) + 1]) +                                       \
   (g).gy[x] * ((v).here[x] - (v).south[x]) + (g).gy_north[x] * ((v).here[x] - (v).north[x]) + \
   (g).gz[x] * ((v).here[x] - (v).down[x]) + (g).gz_up[x] * ((v).here[x] - (v).up[x]))

// First x of a row, from `begin` on, with (x + y + z) mod 2 = colour.
#define FIRST(begin, colour, y, z) ((begin) + (((begin) ^ (y) ^ (z) ^ (colour)) & 1))

// Index of cell x of row (y, z), or of red cell x among red ones.
#define CELL(x, y, z) (((size_t)(z)*ny + (y)) * nx + (x))
#define RED_CELL(x, y, z) (((size_t)(z)*ny + (y)) * ((nx + 1) >> 1) + ((x) >> 1))

// What a sweep will read of the coefficients of one row, some planes ahead. Fetched a line at a time,
// one array after the other, by a stage that has arithmetic to do meanwhile: fetching a row at once
// would wait for memory with all of a core's few outstanding requests taken.
typedef struct {
  global const REAL* row[8];
} Coming;
// Of five arrays, the last has the turns that are left.
INLINE Coming coming_row(int nx, int ny, int y, int z, global const REAL* gx,
                         global const REAL* gy, global const REAL* gz, global const REAL* sink,
                         global const REAL* smoother) {
  const size_t row = CELL(0, y, z);
  const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, z);
  const Coming coming = {{g.gx, g.gy_north, g.gz, sink + row, smoother + row, smoother + row,
                          smoother + row, smoother + row}};
  return coming;
}
INLINE Coming with_weights(Coming coming, global const REAL* wx, global const REAL* wy,
                           global const REAL* wz) {
  coming.row[5] = wx;
  coming.row[6] = wy;
  coming.row[7] = wz;
  return coming;
}
// For every other cell x of a row: all arrays have had their turn after 16 cells.
INLINE void fetch_coming(const Coming* coming, int x) {
  global const REAL* from = coming->row[(x >> 1) & 7] + (x & ~15);
  PREFETCH(from);
  if (sizeof(REAL) > 4) PREFETCH(from + 8);
}

#define GRID_ARGUMENTS                                                      \
  const int nx, const int ny, const int nz, global const REAL *restrict gx, \
      global const REAL *restrict gy, global const REAL *restrict gz

// The tile of this item: `tile_...` cells along each axis, in order x, y, z.
#define TILE_ARGUMENTS const int tile_x, const int tile_y, const int tile_z
INLINE Box tile_box(int tile, int tile_x, int tile_y, int tile_z, int nx, int ny, int nz) {
  const int across = (nx - 1) / tile_x + 1, along = (ny - 1) / tile_y + 1;
  const int x = tile % across * tile_x, y = tile / across % along * tile_y,
            z = tile / across / along * tile_z;
  const Box box = {x, min(x + tile_x, nx), y, min(y + tile_y, ny), z, min(z + tile_z, nz)};
  return box;
}

// One stage on plane y of `box`: out[x] = `value` on the cells of `colour`; g, v and i are the
// conductances, the ring's rows and the index of the row's first cell.
#define STAGE(box, colour, plane_y, value)                                      \
  if ((plane_y) >= (box).y0 && (plane_y) < (box).y1) {                          \
    for (int k = (box).z0; k < (box).z1; ++k) {                                 \
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, (plane_y), k); \
      const Rows v = rows_at(ring, (plane_y), k);                               \
      const size_t i = CELL(0, plane_y, k);                                     \
      global vec* out = ring_row(ring, (plane_y), k);                           \
      for (int x = FIRST((box).x0, colour, plane_y, k); x < (box).x1; x += 2) { \
        out[x] = (value);                                                       \
      }                                                                         \
    }                                                                           \
  }
#define RED 0
#define BLACK 1

// (A φ) in flux form; with black neighbours solved for, (S φ) at a red cell.
#define IMAGE(g, v, x, i) (OUTFLOW(g, v, x) + sink[(i) + (x)] * (v).here[x])

// The ring of this item's tile.
#define TILE_SCRATCH scratch + (size_t)tile* scratch_cells
