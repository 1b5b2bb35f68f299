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
// Each being one plane and one colour after the one before, all stages have cells of the same x in
// row z, and one loop along x does them all: reading ahead from memory and arithmetic on what is in
// the cache alternate cell by cell.
//
// Around its tile an item computes as many cells once more as the stages need (they are its
// neighbours' too); it writes only its own. Sums are kept per plane y of a tile, so that they are
// the same however the grid is cut along y, the one axis whose cuts follow the number of cores. So
// no value depends on how items are scheduled, nor on how many cores there are.
//
#if GROUPS != 1
#error "streams hold all lanes of a cell in one vector"
#endif

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

// The ring of a sweep keeps, of each row, the cells with even x before those with odd x: a stage
// then walks through memory without gaps, on fewer pages. Up to two cells more a row than
// make_ring's.
INLINE Ring make_split_ring(global ring_vec* memory, int depth, Box box) {
  Ring ring = make_ring(memory, depth, box);
  ring.x0 = (box.x0 - 1) >> 1;
  ring.row = 2 * ((box.x1 >> 1) - ring.x0 + 1);
  ring.plane = ring.row * (box.z1 - box.z0 + 2);
  return ring;
}
// Pointer p such that p[e] is cell (2 e + parity, y, z).
INLINE global ring_vec* half_row(Ring ring, int y, int z, int parity) {
  return ring_row(ring, y, z) + parity * (ring.row >> 1);
}

// Rows of the ring around the cells (2 e + parity, y, z), each at [e]; of those beside them along x
// the one to the west.
typedef struct {
  global const ring_vec *here, *west, *south, *north, *down, *up;
} Rows;
INLINE Rows rows_at(Ring ring, int y, int z, int parity) {
  Rows rows;
  rows.here = half_row(ring, y, z, parity);
  rows.west = half_row(ring, y, z, 1 - parity) + parity - 1;
  rows.south = half_row(ring, y - 1, z, parity);
  rows.north = half_row(ring, y + 1, z, parity);
  rows.down = rows.here - ring.row;
  rows.up = rows.here + ring.row;
  return rows;
}

// Σ G φ_neighbour of the e-th cell
#define INFLOW(g, v, e)                                                               \
  ((g).west * (v).west[e] + (g).east * (v).west[(e) + 1] + (g).south * (v).south[e] + \
   (g).north * (v).north[e] + (g).down * (v).down[e] + (g).up * (v).up[e])

// Σ G (φ − φ_neighbour)
#define OUTFLOW(g, v, e)                                                                   \
  ((g).west * ((v).here[e] - (v).west[e]) + (g).east * ((v).here[e] - (v).west[(e) + 1]) + \
   (g).south * ((v).here[e] - (v).south[e]) + (g).north * ((v).here[e] - (v).north[e]) +   \
   (g).down * ((v).here[e] - (v).down[e]) + (g).up * ((v).here[e] - (v).up[e]))

// (A φ) in flux form; with black neighbours solved for, (S φ) at a red cell.
#define IMAGE(g, v, e) (OUTFLOW(g, v, e) + (g).sink * (v).here[e])

// Fetches, over all e, the stencils of a whole row (from STENCIL_ROW(y, z, 0) on) a line at a time:
// two of floats fill one.
#define PREFETCH_STENCILS(row, e)         \
  PREFETCH((row) + ((e)&1) * HALF + (e)); \
  if (sizeof(REAL) > 4) PREFETCH((row) + (~(e)&1) * HALF + (e))

// The tile of this item: `tile_...` cells along each axis, in order x, y, z.
#define TILE_ARGUMENTS const int tile_x, const int tile_y, const int tile_z
INLINE Box tile_box(int tile, int tile_x, int tile_y, int tile_z, int nx, int ny, int nz) {
  const int across = (nx - 1) / tile_x + 1, along = (ny - 1) / tile_y + 1;
  const int x = tile % across * tile_x, y = tile / across % along * tile_y,
            z = tile / across / along * tile_z;
  const Box box = {x, min(x + tile_x, nx), y, min(y + tile_y, ny), z, min(z + tile_z, nz)};
  return box;
}

// Where the sums of plane y = 0 of a tile stand: sums [tile along z][tile along x][y].
INLINE size_t first_sum(Box own, int tile_x, int tile_z, int nx, int ny) {
  return ((size_t)(own.z0 / tile_z) * ((nx - 1) / tile_x + 1) + own.x0 / tile_x) * ny;
}

#define HAS_ROW(box, y, z) ((y) >= (box).y0 && (y) < (box).y1 && (z) >= (box).z0 && (z) < (box).z1)

// The cells of one parity of row (y, z) that a stage works on: the e-th ones, begin <= e < end;
// none where the row is not in its box.
typedef struct {
  int begin, end;
} Span;
INLINE Span span_of(Box box, int y, int z, int parity) {
  const Span span = {(box.x0 + 1 - parity) >> 1,
                     HAS_ROW(box, y, z) ? (box.x1 + 1 - parity) >> 1 : 0};
  return span;
}
#define WITHIN(span, e) ((e) >= (span).begin && (e) < (span).end)

// The ring of this item's tile.
#define TILE_SCRATCH scratch + (size_t)tile* scratch_cells
