// The V-cycle's halves on one level and the step of conjugate gradients, each as one sweep through
// memory, for devices with few fast cores and large caches.
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
// The arithmetic is that of grid_operator.cl and grid_transfer.cl, where it is explained; red is
// (x+y+z) even. Coarsening is by 2 or 1 along each axis: coarse cell X holds the cells x with
// x >> half_x = X, half_x = 1 or 0.

#if GROUPS != 1
#error "streams hold all lanes of a cell in one vector"
#endif

// Helpers must be inlined: only then does the compiler use vectors of full width everywhere.
#define INLINE inline __attribute__((always_inline))

#ifdef __has_builtin
#if __has_builtin(__builtin_prefetch)
#define PREFETCH(address) __builtin_prefetch(address)
#endif
#if __has_builtin(__builtin_nontemporal_store)
#define STREAM_OUT(value, address) __builtin_nontemporal_store(value, address)
#endif
#endif
#ifndef PREFETCH
#define PREFETCH(address)
#endif
#ifndef STREAM_OUT
#define STREAM_OUT(value, address) (*(address) = (value))
#endif

typedef struct {
  int x0, x1, y0, y1, z0, z1;
} Box;

// Where the row after (y, z) in a sweep through `box` begins, as seen from row (y, z).
INLINE long next_row(Box box, int nx, int ny, int y, int z) {
  return z + 1 < box.z1 ? (long)nx * ny : nx - (long)(box.z1 - 1 - box.z0) * nx * ny;
}

// Fetches `count` numbers early.
INLINE void fetch(global const REAL* from, int count) {
  for (int i = 0; i < count; i += 64 / (int)sizeof(REAL)) PREFETCH(from + i);
}

// `box` and what lies up to `more` cells around it inside the grid.
INLINE Box around(Box box, int more, int nx, int ny, int nz) {
  const Box result = {max(box.x0 - more, 0),  min(box.x1 + more, nx), max(box.y0 - more, 0),
                      min(box.y1 + more, ny), max(box.z0 - more, 0),  min(box.z1 + more, nz)};
  return result;
}

// A ring of planes: cell (x, y, z) is at [y mod depth][z − z0 + 1][x − x0 + 1]; the rows and
// columns on its rim stay zero, being outside the grid wherever they are read.
typedef struct {
  global vec* planes;
  int depth, row, plane, x0, z0;
} Ring;

INLINE Ring make_ring(global vec* memory, int depth, Box box) {
  Ring ring;
  ring.planes = memory;
  ring.depth = depth;
  ring.row = box.x1 - box.x0 + 2;
  ring.plane = ring.row * (box.z1 - box.z0 + 2);
  ring.x0 = box.x0 - 1;
  ring.z0 = box.z0 - 1;
  return ring;
}

INLINE void clear(global vec* values, int count) {
  for (int i = 0; i < count; ++i) values[i] = (vec)(0);
}

// Pointer p such that p[x] is cell (x, y, z).
INLINE global vec* ring_row(Ring ring, int y, int z) {
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
  global const vec *here, *south, *north, *down, *up;
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

#define GRID_ARGUMENTS                                                      \
  const int nx, const int ny, const int nz, global const REAL *restrict gx, \
      global const REAL *restrict gy, global const REAL *restrict gz

#define COARSE_ARGUMENTS                                                                          \
  const int cx, const int cy, const int cz, const int half_x, const int half_y, const int half_z, \
      global const REAL *restrict wx, global const REAL *restrict wy,                             \
      global const REAL *restrict wz

// Fetches the coefficients of row (y, z) but for `inverse`, which is needed a plane sooner than the
// others: that of the row after.
INLINE void fetch_coefficients(Box box, int nx, int ny, int y, int z, global const REAL* gx,
                               global const REAL* gy, global const REAL* gz,
                               global const REAL* inverse, global const REAL* wx,
                               global const REAL* wy, global const REAL* wz) {
  const int count = box.x1 - box.x0;
  const size_t row = ((size_t)z * ny + y) * nx + box.x0;
  const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, z);
  fetch(g.gx + box.x0, count + 1);
  fetch(g.gy_north + box.x0, count);
  fetch(g.gz + box.x0, count);
  fetch(inverse + row + next_row(box, nx, ny, y, z), count);
  fetch(wx + row, count);
  fetch(wy + row, count);
  fetch(wz + row, count);
}

// The tile of this item: `tile_...` cells along each axis, in order x, y, z.
#define TILE_ARGUMENTS const int tile_x, const int tile_y, const int tile_z
INLINE Box tile_box(int tile, int tile_x, int tile_y, int tile_z, int nx, int ny, int nz) {
  const int across = (nx - 1) / tile_x + 1, along = (ny - 1) / tile_y + 1;
  const int x = tile % across * tile_x, y = tile / across % along * tile_y,
            z = tile / across / along * tile_z;
  const Box box = {x, min(x + tile_x, nx), y, min(y + tile_y, ny), z, min(z + tile_z, nz)};
  return box;
}

// Adds what red cells x0 ≤ x < x1 of fine row (y, z) give to the coarse rows of `sums`: residual
// Σ G φ_neighbour, times the interpolation weights. w: of the row; a fine cell has one own coarse
// cell and one across, along every axis that is coarsened.
INLINE void give(Conductances g, Rows rows, int x0, int x1, int y, int z, int half_x, int half_y,
                 int half_z, global const REAL* wx, global const REAL* wy, global const REAL* wz,
                 Ring sums) {
  const int own_y = y >> half_y, far_y = own_y + half_y * (2 * (y & 1) - 1);
  const int own_z = z >> half_z, far_z = own_z + half_z * (2 * (z & 1) - 1);
  global vec* oo = ring_row(sums, own_y, own_z);
  global vec* fo = ring_row(sums, far_y, own_z);
  global vec* of = ring_row(sums, own_y, far_z);
  global vec* ff = ring_row(sums, far_y, far_z);
  const int first = FIRST(x0, 0, y, z);
  if (first >= x1) return;
  if (!half_x) {
    for (int x = first; x < x1; x += 2) {
      const vec residual = INFLOW(g, rows, x);
      const REAL ty = half_y ? wy[x] : 0, tz = half_z ? wz[x] : 0;
      oo[x] += ((1 - ty) * (1 - tz)) * residual;
      if (half_y) fo[x] += (ty * (1 - tz)) * residual;
      if (half_z) of[x] += ((1 - ty) * tz) * residual;
      if (half_y && half_z) ff[x] += (ty * tz) * residual;
    }
    return;
  }
  // x = 2k + odd: the lower of the two coarse cells is k + odd − 1, the upper k + odd; what goes to
  // the upper one waits for the next cell's share to the lower.
  const int odd = first & 1;
  int lower = (first >> 1) + odd - 1;
  vec wait_oo = (vec)(0), wait_fo = (vec)(0), wait_of = (vec)(0), wait_ff = (vec)(0);
  for (int x = first; x < x1; x += 2, ++lower) {
    const vec residual = INFLOW(g, rows, x);
    const REAL ty = half_y ? wy[x] : 0, tz = half_z ? wz[x] : 0;
    const REAL to_lower = odd ? 1 - wx[x] : wx[x];
    const vec low = to_lower * residual, high = residual - low;
    const REAL w_oo = (1 - ty) * (1 - tz), w_fo = ty * (1 - tz), w_of = (1 - ty) * tz,
               w_ff = ty * tz;
    oo[lower] += wait_oo + w_oo * low;
    fo[lower] += wait_fo + w_fo * low;
    of[lower] += wait_of + w_of * low;
    ff[lower] += wait_ff + w_ff * low;
    wait_oo = w_oo * high;
    wait_fo = w_fo * high;
    wait_of = w_of * high;
    wait_ff = w_ff * high;
  }
  oo[lower] += wait_oo;
  fo[lower] += wait_fo;
  of[lower] += wait_of;
  ff[lower] += wait_ff;
}

// From zero: red then black Gauss-Seidel, residual, restriction: coarse = Pᵀ (rhs − A φ). Tiles are
// of coarse cells.
INLINE void down_tile(Box own, GRID_ARGUMENTS, global const REAL* restrict inverse,
                      COARSE_ARGUMENTS, global const vec* restrict rhs, global vec* restrict coarse,
                      global vec* restrict scratch) {
  // Cells whose residual reaches the own coarse cells.
  const Box giving = {max((own.x0 << half_x) - half_x, 0), min((own.x1 << half_x) + half_x, nx),
                      max((own.y0 << half_y) - half_y, 0), min((own.y1 << half_y) + half_y, ny),
                      max((own.z0 << half_z) - half_z, 0), min((own.z1 << half_z) + half_z, nz)};
  const Box black = around(giving, 1, nx, ny, nz), red = around(giving, 2, nx, ny, nz);
  const Ring ring = make_ring(scratch, 4, red);
  clear(ring.planes, ring.depth * ring.plane);
  // The rim takes what belongs to other tiles' coarse cells or, outside the grid, to none.
  const Ring sums = make_ring(scratch + ring.depth * ring.plane, 4, own);
  clear(sums.planes, sums.depth * sums.plane);
  int done = own.y0;
  for (int t = red.y0; t < giving.y1 + 2; ++t) {
    if (t < red.y1) {
      for (int z = red.z0; z < red.z1; ++z) {
        const size_t row = ((size_t)z * ny + t) * nx;
        global vec* out = ring_row(ring, t, z);
        global const vec* next = rhs + row + next_row(red, nx, ny, t, z);
        fetch_coefficients(red, nx, ny, t, z, gx, gy, gz, inverse, wx, wy, wz);
        for (int x = FIRST(red.x0, 0, t, z); x < red.x1; x += 2) {
          PREFETCH(next + x);
          PREFETCH(next + x + 1);
          out[x] = inverse[row + x] * rhs[row + x];
        }
      }
    } else {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    }
    const int b = t - 1;
    if (b >= black.y0 && b < black.y1) {
      for (int z = black.z0; z < black.z1; ++z) {
        const size_t row = ((size_t)z * ny + b) * nx;
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, b, z);
        const Rows rows = rows_at(ring, b, z);
        global vec* out = ring_row(ring, b, z);
        for (int x = FIRST(black.x0, 1, b, z); x < black.x1; x += 2) {
          out[x] = inverse[row + x] * (rhs[row + x] + INFLOW(g, rows, x));
        }
      }
    }
    const int y = t - 2;
    if (y < giving.y0) continue;
    for (int z = giving.z0; z < giving.z1; ++z) {
      const size_t row = ((size_t)z * ny + y) * nx;
      give(conductances_at(gx, gy, gz, nx, ny, y, z), rows_at(ring, y, z), giving.x0, giving.x1, y,
           z, half_x, half_y, half_z, wx + row, wy + row, wz + row, sums);
    }
    // Coarse planes that will receive no more.
    for (; done < own.y1 && (y + 1 == giving.y1 || (done << half_y) + 2 * half_y <= y); ++done) {
      for (int z = own.z0; z < own.z1; ++z) {
        global vec* from = ring_row(sums, done, z);
        global vec* to = coarse + ((size_t)z * cy + done) * cx;
        for (int x = own.x0; x < own.x1; ++x) to[x] = from[x];
      }
      // The plane before takes no more; it may hold another tile's share, and comes round again.
      clear(sums.planes + (done - 1 + sums.depth) % sums.depth * sums.plane, sums.plane);
    }
  }
}

// Corrected red cells of one row: φ = rhs / D + P coarse.
INLINE void correct(int x0, int x1, int nx, int ny, int y, int z, long next,
                    global const REAL* inverse, int cx, int cy, int cz, int half_x, int half_y,
                    int half_z, global const REAL* wx, global const REAL* wy, global const REAL* wz,
                    global const vec* rhs, global const vec* coarse, global const vec* zeros,
                    global vec* out) {
  const int own_y = y >> half_y, far_y = own_y + half_y * (2 * (y & 1) - 1);
  const int own_z = z >> half_z, far_z = own_z + half_z * (2 * (z & 1) - 1);
  const int has_y = far_y >= 0 && far_y < cy, has_z = far_z >= 0 && far_z < cz;
  global const vec* oo = coarse + ((size_t)own_z * cy + own_y) * cx;
  global const vec* fo = has_y ? coarse + ((size_t)own_z * cy + far_y) * cx : zeros;
  global const vec* of = has_z ? coarse + ((size_t)far_z * cy + own_y) * cx : zeros;
  global const vec* ff = has_y && has_z ? coarse + ((size_t)far_z * cy + far_y) * cx : zeros;
  for (int x = FIRST(x0, 0, y, z); x < x1; x += 2) {
    const REAL ty = half_y ? wy[x] : 0, tz = half_z ? wz[x] : 0;
    const REAL w_oo = (1 - ty) * (1 - tz), w_fo = ty * (1 - tz), w_of = (1 - ty) * tz,
               w_ff = ty * tz;
    const int own = x >> half_x;
    PREFETCH(rhs + next + x);
    PREFETCH(rhs + next + x + 1);
    vec sum = w_oo * oo[own] + w_fo * fo[own] + w_of * of[own] + w_ff * ff[own];
    if (half_x) {
      const REAL tx = wx[x];
      const int far = own + 2 * (x & 1) - 1;
      sum *= 1 - tx;
      if (far >= 0 && far < cx) {
        sum += tx * (w_oo * oo[far] + w_fo * fo[far] + w_of * of[far] + w_ff * ff[far]);
      }
    }
    out[x] = inverse[x] * rhs[x] + sum;
  }
}

// The way up: φ = (smoothed from zero) + P coarse on red cells, then black and red Gauss-Seidel;
// the first value of black cells is overwritten unread, that of red ones is rhs / D. With `dots`,
// sums over the own cells: Σ rhs·φ and Σ φ·Aφ.
INLINE void up_tile(Box own, const int dots, GRID_ARGUMENTS, global const REAL* restrict inverse,
                    global const REAL* restrict sink, COARSE_ARGUMENTS,
                    global const vec* restrict rhs, global const vec* restrict coarse,
                    global vec* restrict solution, global vec* restrict scratch, accu_vec* gamma,
                    accu_vec* delta) {
  const Box final = around(own, dots, nx, ny, nz);
  const Box black = around(final, 1, nx, ny, nz), red = around(final, 2, nx, ny, nz);
  const Ring ring = make_ring(scratch, 5, red);
  clear(ring.planes, ring.depth * ring.plane);
  global vec* zeros = scratch + ring.depth * ring.plane;
  clear(zeros, cx);
  accu_vec sum_gamma = (accu_vec)(0), sum_delta = (accu_vec)(0);
  for (int t = red.y0; t < own.y1 + 2 + dots; ++t) {
    if (t < red.y1) {
      for (int z = red.z0; z < red.z1; ++z) {
        const size_t row = ((size_t)z * ny + t) * nx;
        fetch_coefficients(red, nx, ny, t, z, gx, gy, gz, inverse, wx, wy, wz);
        correct(red.x0, red.x1, nx, ny, t, z, next_row(red, nx, ny, t, z), inverse + row, cx, cy,
                cz, half_x, half_y, half_z, wx + row, wy + row, wz + row, rhs + row, coarse, zeros,
                ring_row(ring, t, z));
      }
    } else {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    }
    const int b = t - 1;
    if (b >= black.y0 && b < black.y1) {
      for (int z = black.z0; z < black.z1; ++z) {
        const size_t row = ((size_t)z * ny + b) * nx;
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, b, z);
        const Rows rows = rows_at(ring, b, z);
        global vec* out = ring_row(ring, b, z);
        for (int x = FIRST(black.x0, 1, b, z); x < black.x1; x += 2) {
          out[x] = inverse[row + x] * (rhs[row + x] + INFLOW(g, rows, x));
        }
      }
    }
    const int y = t - 2;
    if (y >= final.y0 && y < final.y1) {
      for (int z = final.z0; z < final.z1; ++z) {
        const size_t row = ((size_t)z * ny + y) * nx;
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, z);
        const Rows rows = rows_at(ring, y, z);
        global vec* out = ring_row(ring, y, z);
        for (int x = FIRST(final.x0, 0, y, z); x < final.x1; x += 2) {
          out[x] = inverse[row + x] * (rhs[row + x] + INFLOW(g, rows, x));
        }
        if (y < own.y0 || y >= own.y1 || z < own.z0 || z >= own.z1) continue;
        vec sum = (vec)(0);
        for (int x = own.x0; x < own.x1; ++x) {
          STREAM_OUT(out[x], solution + row + x);
          sum += out[x] * rhs[row + x];
        }
        sum_gamma += to_accu(sum);
      }
    }
    const int d = t - 3;
    if (!dots || d < own.y0) continue;
    for (int z = own.z0; z < own.z1; ++z) {
      const size_t row = ((size_t)z * ny + d) * nx;
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, d, z);
      const Rows rows = rows_at(ring, d, z);
      vec sum = (vec)(0);
      for (int x = own.x0; x < own.x1; ++x) {
        sum += rows.here[x] * (OUTFLOW(g, rows, x) + sink[row + x] * rows.here[x]);
      }
      sum_delta += to_accu(sum);
    }
  }
  *gamma = sum_gamma;
  *delta = sum_delta;
}

kernel void stream_down(TILE_ARGUMENTS, GRID_ARGUMENTS, global const REAL* restrict inverse,
                        COARSE_ARGUMENTS, global const vec* restrict rhs,
                        global vec* restrict coarse, const int scratch_cells,
                        global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  down_tile(tile_box(tile, tile_x, tile_y, tile_z, cx, cy, cz), nx, ny, nz, gx, gy, gz, inverse, cx,
            cy, cz, half_x, half_y, half_z, wx, wy, wz, rhs, coarse,
            scratch + (size_t)tile * scratch_cells);
}

// dots [tile][2]: Σ rhs·φ and Σ φ·Aφ of each tile.
kernel void stream_up(TILE_ARGUMENTS, const int with_dots, GRID_ARGUMENTS,
                      global const REAL* restrict inverse, global const REAL* restrict sink,
                      COARSE_ARGUMENTS, global const vec* restrict rhs,
                      global const vec* restrict coarse, global vec* restrict solution,
                      global accu_vec* restrict dots, const int scratch_cells,
                      global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  accu_vec gamma, delta;
  up_tile(tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz), with_dots, nx, ny, nz, gx, gy, gz,
          inverse, sink, cx, cy, cz, half_x, half_y, half_z, wx, wy, wz, rhs, coarse, solution,
          scratch + (size_t)tile * scratch_cells, &gamma, &delta);
  if (with_dots) {
    dots[2 * tile] = gamma;
    dots[2 * tile + 1] = delta;
  }
}

// The scalars of the next step from `up_tiles` sums of stream_up and `step_tiles` sums of the last
// stream_step; scalars: {γ, α, β}. p'Ap' = zAz − β² pAp because p' = z + β p is conjugate to p
// (Chronopoulos & Gear 1989), so that α is known before p' is.
kernel void step_scalars(const int up_tiles, const int step_tiles, const int fresh,
                         global const accu_vec* restrict dots,
                         global const accu_vec* restrict steps, global accu_vec* restrict scalars) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0) return;
  accu_vec gamma = (accu_vec)(0), delta = (accu_vec)(0), energy = (accu_vec)(0);
  for (int tile = 0; tile < up_tiles; ++tile) {
    gamma += dots[2 * tile];
    delta += dots[2 * tile + 1];
  }
  accu_vec beta = (accu_vec)(0);
  if (!fresh) {
    for (int tile = 0; tile < step_tiles; ++tile) energy += steps[2 * tile + 1];
    beta = ratio(gamma, scalars[0]);
  }
  scalars[0] = gamma;
  scalars[1] = ratio(gamma, delta - beta * beta * energy);
  scalars[2] = beta;
}

// p' = z + β p, x += α p', r −= α A p'; sums [tile][2]: Σ r² and Σ p'·Ap' of each tile. With
// first_p or first_x, p or x is taken for zero, whatever it holds.
kernel void stream_step(TILE_ARGUMENTS, const int first_p, const int first_x, GRID_ARGUMENTS,
                        global const REAL* restrict sink, global const accu_vec* restrict scalars,
                        global const vec* restrict z, global const vec* restrict before,
                        global vec* restrict p, global vec* restrict x, global vec* restrict r,
                        global accu_vec* restrict sums, const int scratch_cells,
                        global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  const Box box = around(own, 1, nx, ny, nz);
  const Ring ring = make_ring(scratch + (size_t)tile * scratch_cells, 3, box);
  clear(ring.planes, ring.depth * ring.plane);
  const vec alpha = to_vec(scalars[1]), beta = to_vec(scalars[2]);
  accu_vec sum_rr = (accu_vec)(0), sum_energy = (accu_vec)(0);
  for (int t = box.y0; t < own.y1 + 1; ++t) {
    if (t < box.y1) {
      for (int k = box.z0; k < box.z1; ++k) {
        const size_t row = ((size_t)k * ny + t) * nx;
        global vec* out = ring_row(ring, t, k);
        const long next = (long)row + next_row(box, nx, ny, t, k);
        const int count = box.x1 - box.x0;
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, t, k);
        fetch(g.gx + box.x0, count + 1);
        fetch(g.gy_north + box.x0, count);
        fetch(g.gz + box.x0, count);
        fetch(sink + row + box.x0, count);
        for (int i = box.x0; i < box.x1; ++i) {
          PREFETCH(z + next + i);
          PREFETCH(before + next + i);
          PREFETCH(r + row + i);
          PREFETCH(x + row + i);
          out[i] = first_p ? z[row + i] : z[row + i] + beta * before[row + i];
        }
      }
    } else {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    }
    const int y = t - 1;
    if (y < own.y0) continue;
    for (int k = own.z0; k < own.z1; ++k) {
      const size_t row = ((size_t)k * ny + y) * nx;
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, k);
      const Rows rows = rows_at(ring, y, k);
      vec rr = (vec)(0), energy = (vec)(0);
      for (int i = own.x0; i < own.x1; ++i) {
        const vec here = rows.here[i];
        const vec image = OUTFLOW(g, rows, i) + sink[row + i] * here;
        const vec residual = r[row + i] - alpha * image;
        STREAM_OUT(here, p + row + i);
        x[row + i] = first_x ? alpha * here : x[row + i] + alpha * here;
        r[row + i] = residual;
        rr += residual * residual;
        energy += here * image;
      }
      sum_rr += to_accu(rr);
      sum_energy += to_accu(energy);
    }
  }
  sums[2 * tile] = sum_rr;
  sums[2 * tile + 1] = sum_energy;
}

// The last level is a single cell.
kernel void solve_last(global const REAL* restrict inverse, global const vec* restrict rhs,
                       global vec* restrict solution) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0) return;
  solution[0] = inverse[0] * rhs[0];
}

// The cycle and its sums where the finest grid is a single cell already.
kernel void cycle_of_one_cell(global const REAL* restrict inverse, global const REAL* restrict gx,
                              global const REAL* restrict gy, global const REAL* restrict gz,
                              global const REAL* restrict sink, global const vec* restrict rhs,
                              global vec* restrict solution, global accu_vec* restrict dots) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0) return;
  const vec z = inverse[0] * rhs[0];
  solution[0] = z;
  dots[0] = to_accu(z * rhs[0]);
  dots[1] = to_accu(z * ((gx[0] + gx[1] + gy[0] + gy[1] + gz[0] + gz[1] + sink[0]) * z));
}
