// The V-cycle's way down and way up on one level, each as one sweep (grid_stream_prelude.cl).
//
// Transfers are those of grid_transfer.cl, where they are explained. Coarsening is by 2 or 1 along
// each axis: coarse cell X holds the cells x with x >> half_x = X, half_x = 1 or 0.

#define COARSE_ARGUMENTS                                                                          \
  const int cx, const int cy, const int cz, const int half_x, const int half_y, const int half_z, \
      global const REAL *restrict wx, global const REAL *restrict wy,                             \
      global const REAL *restrict wz

// STAGE, fetching what the first stage will read one plane ahead of itself: of row (plane_y + 2, k).
#define STAGE_FETCHING(box, colour, plane_y, value)                                               \
  if ((plane_y) >= (box).y0 && (plane_y) < (box).y1) {                                            \
    const int ahead = min((plane_y) + 2, ny - 1);                                                 \
    for (int k = (box).z0; k < (box).z1; ++k) {                                                   \
      const size_t coming_row_at = CELL(0, ahead, k);                                             \
      const Coming coming =                                                                       \
          with_weights(coming_row(nx, ny, ahead, k, gx, gy, gz, sink, smoother),                  \
                       wx + coming_row_at, wy + coming_row_at, wz + coming_row_at);               \
      global const vec* coming_rhs = rhs + (only_red ? RED_CELL(0, ahead, k) : CELL(0, ahead, k)); \
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, (plane_y), k);                   \
      const Rows v = rows_at(ring, (plane_y), k);                                                 \
      const size_t i = CELL(0, plane_y, k);                                                       \
      global vec* out = ring_row(ring, (plane_y), k);                                             \
      for (int x = FIRST((box).x0, colour, plane_y, k); x < (box).x1; x += 2) {                   \
        fetch_coming(&coming, x);                                                                 \
        PREFETCH(coming_rhs + (only_red ? x >> 1 : x));                                           \
        if (!only_red) PREFETCH(coming_rhs + x + 1);                                              \
        out[x] = (value);                                                                         \
      }                                                                                           \
    }                                                                                             \
  }

// The right-hand side on a red cell.
#define RHS(x, y, z) (only_red ? rhs[RED_CELL(x, y, z)] : rhs[CELL(x, y, z)])

// Adds one residual to the coarse rows it belongs to. Along a coarsened x, x = 2k + odd: the lower
// of its two coarse cells is k + odd − 1, the upper k + odd; what goes to the upper one waits for
// the next cell's share to the lower.
typedef struct {
  global vec *oo, *fo, *of, *ff;  // own and far along y and z
  vec wait_oo, wait_fo, wait_of, wait_ff;
} Givings;

INLINE Givings givings_at(Ring sums, int half_y, int half_z, int y, int z) {
  const int own_y = y >> half_y, far_y = own_y + half_y * (2 * (y & 1) - 1);
  const int own_z = z >> half_z, far_z = own_z + half_z * (2 * (z & 1) - 1);
  Givings to;
  to.oo = ring_row(sums, own_y, own_z);
  to.fo = ring_row(sums, far_y, own_z);
  to.of = ring_row(sums, own_y, far_z);
  to.ff = ring_row(sums, far_y, far_z);
  to.wait_oo = to.wait_fo = to.wait_of = to.wait_ff = (vec)(0);
  return to;
}
INLINE void give(Givings* to, vec residual, int lower, REAL to_lower, REAL ty, REAL tz) {
  const vec low = to_lower * residual, high = residual - low;
  const REAL oo = (1 - ty) * (1 - tz), fo = ty * (1 - tz), of = (1 - ty) * tz, ff = ty * tz;
  to->oo[lower] += to->wait_oo + oo * low;
  to->fo[lower] += to->wait_fo + fo * low;
  to->of[lower] += to->wait_of + of * low;
  to->ff[lower] += to->wait_ff + ff * low;
  to->wait_oo = oo * high;
  to->wait_fo = fo * high;
  to->wait_of = of * high;
  to->wait_ff = ff * high;
}
INLINE void give_the_rest(Givings* to, int lower) {
  to->oo[lower] += to->wait_oo;
  to->fo[lower] += to->wait_fo;
  to->of[lower] += to->wait_of;
  to->ff[lower] += to->wait_ff;
}

// From zero: black, red, black relaxation, residual, restriction: coarse = Pᵀ (rhs − A φ). The
// residual of black cells is zero. Tiles are of coarse cells. With only_red the right-hand side is
// zero on black cells and holds red ones only.
INLINE void down_tile(const int only_red, Box own, GRID_ARGUMENTS, global const REAL* restrict sink,
                      global const REAL* restrict smoother, COARSE_ARGUMENTS,
                      global const vec* restrict rhs, global vec* restrict coarse,
                      global vec* restrict scratch) {
  // Cells whose residual reaches the own coarse cells.
  const Box giving = {max((own.x0 << half_x) - half_x, 0), min((own.x1 << half_x) + half_x, nx),
                      max((own.y0 << half_y) - half_y, 0), min((own.y1 << half_y) + half_y, ny),
                      max((own.z0 << half_z) - half_z, 0), min((own.z1 << half_z) + half_z, nz)};
  const int lead = only_red ? 0 : 1;
  const Box black = around(giving, 1, nx, ny, nz), red = around(giving, 2, nx, ny, nz);
  const Box first = around(giving, 2 + lead, nx, ny, nz);
  const Ring ring = make_ring(scratch, 5, first);
  clear(ring.planes, ring.depth * ring.plane);
  // The rim takes what belongs to other tiles' coarse cells or, outside the grid, to none.
  const Ring sums = make_ring(scratch + ring.depth * ring.plane, 4, own);
  clear(sums.planes, sums.depth * sums.plane);
  int done = own.y0;
  for (int t = first.y0; t < giving.y1 + 2 + lead; ++t) {
    if (t < first.y1) {
      for (int k = first.z0; k < first.z1; ++k) {
        global vec* out = ring_row(ring, t, k);
        const size_t i = CELL(0, t, k);
        for (int x = FIRST(first.x0, !only_red, t, k); x < first.x1; x += 2) {
          out[x] = smoother[i + x] * (only_red ? RHS(x, t, k) : rhs[i + x]);
        }
      }
    } else {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    }
    if (only_red) {
      STAGE_FETCHING(black, BLACK, t - 1, smoother[i + x] * INFLOW(g, v, x))
    } else {
      STAGE_FETCHING(red, RED, t - 1, smoother[i + x] * (rhs[i + x] + INFLOW(g, v, x)))
      STAGE(black, BLACK, t - 2, smoother[i + x] * (rhs[i + x] + INFLOW(g, v, x)))
    }
    const int y = t - 2 - lead;
    if (y < giving.y0) continue;
    for (int k = giving.z0; k < giving.z1; ++k) {
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, k);
      const Rows v = rows_at(ring, y, k);
      const size_t i = CELL(0, y, k);
      Givings to = givings_at(sums, half_y, half_z, y, k);
      const int begin = FIRST(giving.x0, RED, y, k), odd = begin & half_x;
      int lower = (begin >> half_x) + odd - half_x;
      for (int x = begin; x < giving.x1; x += 2, lower += 2 - half_x) {
        const vec residual = RHS(x, y, k) - IMAGE(g, v, x, i);
        const REAL ty = half_y ? wy[i + x] : 0, tz = half_z ? wz[i + x] : 0;
        const REAL to_lower = !half_x ? 1 : odd ? 1 - wx[i + x] : wx[i + x];
        give(&to, residual, lower, to_lower, ty, tz);
      }
      if (half_x && begin < giving.x1) give_the_rest(&to, lower);
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

// The coarse rows that interpolate to fine row (y, z).
typedef struct {
  global const vec *oo, *fo, *of, *ff;
} Parents;
INLINE Parents parents_at(int y, int z, int cx, int cy, int cz, int half_y, int half_z,
                          global const vec* coarse, global const vec* zeros) {
  const int own_y = y >> half_y, far_y = own_y + half_y * (2 * (y & 1) - 1);
  const int own_z = z >> half_z, far_z = own_z + half_z * (2 * (z & 1) - 1);
  const int has_y = far_y >= 0 && far_y < cy, has_z = far_z >= 0 && far_z < cz;
  Parents from;
  from.oo = coarse + ((size_t)own_z * cy + own_y) * cx;
  from.fo = has_y ? coarse + ((size_t)own_z * cy + far_y) * cx : zeros;
  from.of = has_z ? coarse + ((size_t)far_z * cy + own_y) * cx : zeros;
  from.ff = has_y && has_z ? coarse + ((size_t)far_z * cy + far_y) * cx : zeros;
  return from;
}
// (P coarse) at cell x.
INLINE vec interpolated(Parents from, int x, int cx, int half_x, REAL tx, REAL ty, REAL tz) {
  const REAL oo = (1 - ty) * (1 - tz), fo = ty * (1 - tz), of = (1 - ty) * tz, ff = ty * tz;
  const int own = x >> half_x;
  vec sum = oo * from.oo[own] + fo * from.fo[own] + of * from.of[own] + ff * from.ff[own];
  if (half_x) {
    const int far = own + 2 * (x & 1) - 1;
    sum *= 1 - tx;
    if (far >= 0 && far < cx) {
      sum += tx * (oo * from.oo[far] + fo * from.fo[far] + of * from.of[far] + ff * from.ff[far]);
    }
  }
  return sum;
}

// Energy of a black cell, solved for, and of its bonds: Σ G (φ − φ_neighbour)² + sink φ².
INLINE vec black_energy(Conductances g, Rows v, int x, REAL inverse, REAL sink) {
  const vec here = inverse * INFLOW(g, v, x);
  const vec west = here - v.here[x - 1], east = here - v.here[x + 1];
  const vec south = here - v.south[x], north = here - v.north[x];
  const vec down = here - v.down[x], up = here - v.up[x];
  return g.gx[x] * (west * west) + g.gx[x + 1] * (east * east) + g.gy[x] * (south * south) +
         g.gy_north[x] * (north * north) + g.gz[x] * (down * down) + g.gz_up[x] * (up * up) +
         sink * (here * here);
}

// Σ coefficient φ² over the own red cells of a row.
#define ADD_ENERGY(coefficient)                              \
  for (int x = FIRST(own.x0, RED, y, k); x < own.x1; x += 2) \
    energy += (coefficient) * (out[x] * out[x]);

// The way up: φ = (red relaxed from zero) + P coarse on red cells, then black, red, black
// relaxation. With only_red, `rhs` and `solution` hold red cells only, and there are sums over the
// own cells: γ = Σ rhs·φ and δ = φ·Sφ. With black cells solved for, the latter is the energy of the
// whole field: Σ G (φ_r − φ_b)² over all bonds, which black cells see, and Σ (sink + G of faces on
// the surface) φ². All terms are positive, and what rounding does to φ_b counts in second order.
INLINE void up_tile(const int only_red, Box own, GRID_ARGUMENTS, global const REAL* restrict sink,
                    global const REAL* restrict smoother, COARSE_ARGUMENTS,
                    global const vec* restrict rhs, global const vec* restrict coarse,
                    global vec* restrict solution, global vec* restrict scratch, accu_vec* gamma,
                    accu_vec* delta) {
  // Stages: black from the right-hand side (not with only_red), red with correction, black, red,
  // black; each one cell less around the tile, one plane later.
  const int lead = only_red ? 0 : 1;
  const Box relaxed = around(own, 1, nx, ny, nz);    // red
  const Box middle = around(own, 2, nx, ny, nz);     // black
  const Box corrected = around(own, 3, nx, ny, nz);  // red
  const Box first = around(own, 3 + lead, nx, ny, nz);
  const Ring ring = make_ring(scratch, 5 + lead, first);
  clear(ring.planes, ring.depth * ring.plane);
  global vec* zeros = scratch + ring.depth * ring.plane;
  clear(zeros, cx);
  accu_vec sum_gamma = (accu_vec)(0), sum_delta = (accu_vec)(0);
  for (int t = first.y0; t < own.y1 + 3 + lead; ++t) {
    if (t < first.y1) {
      for (int k = first.z0; !only_red && k < first.z1; ++k) {
        const size_t i = CELL(0, t, k);
        global vec* out = ring_row(ring, t, k);
        for (int x = FIRST(first.x0, BLACK, t, k); x < first.x1; x += 2) {
          out[x] = smoother[i + x] * rhs[i + x];
        }
      }
    } else {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    }
    const int c = t - lead;
    if (c >= corrected.y0 && c < corrected.y1) {
      for (int k = corrected.z0; k < corrected.z1; ++k) {
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, c, k);
        const Rows v = rows_at(ring, c, k);
        const size_t i = CELL(0, c, k);
        const Parents from = parents_at(c, k, cx, cy, cz, half_y, half_z, coarse, zeros);
        global vec* out = ring_row(ring, c, k);
        for (int x = FIRST(corrected.x0, RED, c, k); x < corrected.x1; x += 2) {
          const vec right = only_red ? RHS(x, c, k) : RHS(x, c, k) + INFLOW(g, v, x);
          out[x] = smoother[i + x] * right + interpolated(from, x, cx, half_x, wx[i + x],
                                                          half_y ? wy[i + x] : 0,
                                                          half_z ? wz[i + x] : 0);
        }
      }
    }
    if (only_red) {
      STAGE_FETCHING(middle, BLACK, t - 1, smoother[i + x] * INFLOW(g, v, x))
    } else {
      STAGE_FETCHING(middle, BLACK, t - 2, smoother[i + x] * (rhs[i + x] + INFLOW(g, v, x)))
    }
    const int y = t - 2 - lead;
    if (y >= relaxed.y0 && y < relaxed.y1) {
      for (int k = relaxed.z0; k < relaxed.z1; ++k) {
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, k);
        const Rows v = rows_at(ring, y, k);
        const size_t i = CELL(0, y, k);
        global vec* out = ring_row(ring, y, k);
        for (int x = FIRST(relaxed.x0, RED, y, k); x < relaxed.x1; x += 2) {
          out[x] += smoother[i + x] * (RHS(x, y, k) - IMAGE(g, v, x, i));
        }
        if (!only_red || y < own.y0 || y >= own.y1 || k < own.z0 || k >= own.z1) continue;
        vec sum = (vec)(0), energy = (vec)(0);
        const size_t j = RED_CELL(0, y, k);
        for (int x = FIRST(own.x0, RED, y, k); x < own.x1; x += 2) {
          STREAM_OUT(out[x], solution + j + (x >> 1));
          sum += out[x] * rhs[j + (x >> 1)];
          energy += sink[i + x] * (out[x] * out[x]);
        }
        if (y == 0) ADD_ENERGY(g.gy[x])
        if (y == ny - 1) ADD_ENERGY(g.gy_north[x])
        if (k == 0) ADD_ENERGY(g.gz[x])
        if (k == nz - 1) ADD_ENERGY(g.gz_up[x])
        if (own.x0 == 0 && !((y ^ k) & 1)) energy += g.gx[0] * (out[0] * out[0]);
        if (own.x1 == nx && !((nx - 1 + y + k) & 1)) {
          energy += g.gx[nx] * (out[nx - 1] * out[nx - 1]);
        }
        sum_gamma += to_accu(sum);
        sum_delta += to_accu(energy);
      }
    }
    const int d = t - 3 - lead;
    if (d < own.y0 || d >= own.y1) continue;
    for (int k = own.z0; k < own.z1; ++k) {
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, d, k);
      const Rows v = rows_at(ring, d, k);
      const size_t i = CELL(0, d, k);
      if (!only_red) {
        global vec* out = ring_row(ring, d, k);
        for (int x = FIRST(own.x0, BLACK, d, k); x < own.x1; x += 2) {
          out[x] = smoother[i + x] * (rhs[i + x] + INFLOW(g, v, x));
        }
        for (int x = own.x0; x < own.x1; ++x) solution[i + x] = out[x];
        continue;
      }
      vec energy = (vec)(0);
      for (int x = FIRST(own.x0, BLACK, d, k); x < own.x1; x += 2) {
        energy += black_energy(g, v, x, smoother[i + x], sink[i + x]);
      }
      sum_delta += to_accu(energy);
    }
  }
  *gamma = sum_gamma;
  *delta = sum_delta;
}

kernel void stream_down(TILE_ARGUMENTS, const int only_red, GRID_ARGUMENTS,
                        global const REAL* restrict sink, global const REAL* restrict smoother,
                        COARSE_ARGUMENTS, global const vec* restrict rhs,
                        global vec* restrict coarse, const int scratch_cells,
                        global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, cx, cy, cz);
  if (only_red) {
    down_tile(1, own, nx, ny, nz, gx, gy, gz, sink, smoother, cx, cy, cz, half_x, half_y, half_z,
              wx, wy, wz, rhs, coarse, TILE_SCRATCH);
  } else {
    down_tile(0, own, nx, ny, nz, gx, gy, gz, sink, smoother, cx, cy, cz, half_x, half_y, half_z,
              wx, wy, wz, rhs, coarse, TILE_SCRATCH);
  }
}

// dots [tile][2]: γ and δ of each tile.
kernel void stream_up(TILE_ARGUMENTS, const int only_red, GRID_ARGUMENTS,
                      global const REAL* restrict sink, global const REAL* restrict smoother,
                      COARSE_ARGUMENTS, global const vec* restrict rhs,
                      global const vec* restrict coarse, global vec* restrict solution,
                      global accu_vec* restrict dots, const int scratch_cells,
                      global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  accu_vec gamma, delta;
  if (only_red) {
    up_tile(1, own, nx, ny, nz, gx, gy, gz, sink, smoother, cx, cy, cz, half_x, half_y, half_z, wx,
            wy, wz, rhs, coarse, solution, TILE_SCRATCH, &gamma, &delta);
    dots[2 * tile] = gamma;
    dots[2 * tile + 1] = delta;
  } else {
    up_tile(0, own, nx, ny, nz, gx, gy, gz, sink, smoother, cx, cy, cz, half_x, half_y, half_z, wx,
            wy, wz, rhs, coarse, solution, TILE_SCRATCH, &gamma, &delta);
  }
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
