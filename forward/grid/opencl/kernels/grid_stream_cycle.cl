// The V-cycle's way down and way up on one level, each as one sweep (grid_stream_prelude.cl).
//
// Transfers are those of grid_stencil_prelude.cl, where they are explained. Coarsening is by 2 or 1
// along each axis: coarse cell X holds the cells x with x >> half_x = X, half_x = 1 or 0.

#define COARSE_ARGUMENTS                                                                          \
  const int cx, const int cy, const int cz, const int half_x, const int half_y, const int half_z, \
      global const Weights *restrict weights

// The right-hand side in row (y, z) from the first cell of a parity on: with only_red, which holds
// red cells alone, its e-th cell is at [e], else at [2 e].
INLINE global const vec* right_row(const int only_red, global const vec* rhs, int nx, int ny, int y,
                                   int z, int parity) {
  return rhs + (only_red ? RED_ROW(y, z) : CELL(parity, y, z));
}
#define AT(e) (only_red ? (e) : 2 * (e))

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
INLINE void give(Givings* to, vec residual, long lower, REAL to_lower, REAL ty, REAL tz) {
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
INLINE void down_tile(const int only_red, Box own, GRID_ARGUMENTS, COARSE_ARGUMENTS,
                      global const vec* restrict rhs, global vec* restrict coarse,
                      global vec* restrict scratch) {
  // Cells whose residual reaches the own coarse cells.
  const Box giving = {max((own.x0 << half_x) - half_x, 0), min((own.x1 << half_x) + half_x, nx),
                      max((own.y0 << half_y) - half_y, 0), min((own.y1 << half_y) + half_y, ny),
                      max((own.z0 << half_z) - half_z, 0), min((own.z1 << half_z) + half_z, nz)};
  const int lead = only_red ? 0 : 1;
  const Box black = around(giving, 1, nx, ny, nz), red = around(giving, 2, nx, ny, nz);
  const Box first = around(giving, 2 + lead, nx, ny, nz);
  const Ring ring = make_split_ring(scratch, 4 + lead, first);
  clear(ring.planes, ring.depth * ring.plane);
  // The rim takes what belongs to other tiles' coarse cells or, outside the grid, to none.
  const Ring sums = make_ring(scratch + ring.depth * ring.plane, 4, own);
  clear(sums.planes, sums.depth * sums.plane);
  int done = own.y0;
  for (int t = first.y0; t < giving.y1 + 2 + lead; ++t) {
    if (t >= first.y1) clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    const int y = t - 2 - lead;
    for (int k = first.z0; k < first.z1; ++k) {
      const int parity = PARITY(!only_red, t, k), odd = parity & half_x, b = t - 1 - lead;
      const Span all = span_of(first, first.y0, k, parity);
      const Span firsts = span_of(first, t, k, parity), reds = span_of(red, t - 1, k, parity),
                 blacks = span_of(black, b, k, parity), gives = span_of(giving, y, k, parity);
      global vec* out0 = half_row(ring, t, k, parity);
      global vec* out1 = half_row(ring, t - 1, k, parity);
      global vec* out_b = half_row(ring, b, k, parity);
      const Rows v1 = rows_at(ring, t - 1, k, parity), vb = rows_at(ring, b, k, parity),
                 v = rows_at(ring, y, k, parity);
      global const Stencil* g0 = stencils + STENCIL_ROW(t, k, parity);
      global const Stencil* g1 = stencils + STENCIL_ROW(t - 1, k, parity);
      global const Stencil* gb = stencils + STENCIL_ROW(b, k, parity);
      global const Stencil* g = stencils + STENCIL_ROW(y, k, parity);
      global const Weights* w = weights + RED_ROW(y, k);
      global const vec* right0 = right_row(only_red, rhs, nx, ny, t, k, parity);
      global const vec* right1 = right_row(only_red, rhs, nx, ny, t - 1, k, parity);
      global const vec* right_b = right_row(only_red, rhs, nx, ny, b, k, parity);
      global const vec* right = right_row(only_red, rhs, nx, ny, y, k, parity);
      const int ahead = min(t + 1, ny - 1);
      global const Stencil* next = stencils + STENCIL_ROW(ahead, k, 0);
      global const Weights* next_weights = weights + RED_ROW(ahead, k);
      global const vec* next_right = right_row(only_red, rhs, nx, ny, ahead, k, 0);
      Givings to = givings_at(sums, half_y, half_z, y, k);
      // Every stage one cell behind the one before, which may then still be under way.
      for (long i = all.begin; i < all.end + 2 + lead; ++i) {
        PREFETCH(next_right + AT(i));
        if (!only_red) PREFETCH(next_right + 2 * i + 1);
        if (WITHIN(firsts, i)) out0[i] = g0[i].smoother * right0[AT(i)];
        if (!only_red && WITHIN(reds, i - 1)) {
          const long e = i - 1;
          out1[e] = g1[e].smoother * (right1[AT(e)] + INFLOW(g1[e], v1, e));
        }
        PREFETCH_STENCILS(next, i);
        if (WITHIN(blacks, i - 1 - lead)) {
          const long e = i - 1 - lead;
          out_b[e] = gb[e].smoother *
                     (only_red ? INFLOW(gb[e], vb, e) : right_b[AT(e)] + INFLOW(gb[e], vb, e));
        }
        if (WITHIN(gives, i - 2 - lead)) {
          const long e = i - 2 - lead;
          PREFETCH(next_weights + e);
          const long lower = half_x ? e + odd - 1 : 2 * e + parity;
          const vec residual = right[AT(e)] - IMAGE(g[e], v, e);
          const REAL to_lower = !half_x ? 1 : odd ? 1 - w[e].x : w[e].x;
          give(&to, residual, lower, to_lower, w[e].y, w[e].z);
        }
      }
      if (half_x && gives.begin < gives.end) give_the_rest(&to, gives.end + odd - 1);
    }
    if (y < giving.y0) continue;
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
INLINE vec interpolated(Parents from, long x, int cx, int half_x, REAL tx, REAL ty, REAL tz) {
  const REAL oo = (1 - ty) * (1 - tz), fo = ty * (1 - tz), of = (1 - ty) * tz, ff = ty * tz;
  const long own = x >> half_x;
  vec sum = oo * from.oo[own] + fo * from.fo[own] + of * from.of[own] + ff * from.ff[own];
  if (half_x) {
    const long far = own + 2 * (x & 1) - 1;
    sum *= 1 - tx;
    if (far >= 0 && far < cx) {
      sum += tx * (oo * from.oo[far] + fo * from.fo[far] + of * from.of[far] + ff * from.ff[far]);
    }
  }
  return sum;
}

// Energy of the e-th cell, black and solved for, and of its bonds: Σ G (φ − φ_neighbour)² + sink
// φ².
INLINE vec black_energy(Stencil g, Rows v, long e) {
  const vec here = g.smoother * INFLOW(g, v, e);
  const vec west = here - v.west[e], east = here - v.west[e + 1];
  const vec south = here - v.south[e], north = here - v.north[e];
  const vec down = here - v.down[e], up = here - v.up[e];
  return g.west * (west * west) + g.east * (east * east) + g.south * (south * south) +
         g.north * (north * north) + g.down * (down * down) + g.up * (up * up) +
         g.sink * (here * here);
}

// The way up: φ = (red relaxed from zero) + P coarse on red cells, then black, red, black
// relaxation. With only_red, `rhs` and `solution` hold red cells only, and there are sums over each
// plane y of the own cells, dots [y][2]: γ = Σ rhs·φ and δ = φ·Sφ. With black cells solved for, the
// latter is the energy of the whole field: Σ G (φ_r − φ_b)² over all bonds, which black cells see,
// and Σ (sink + G of faces on the surface) φ². All terms are positive, and what rounding does to
// φ_b counts in second order.
INLINE void up_tile(const int only_red, Box own, GRID_ARGUMENTS, COARSE_ARGUMENTS,
                    global const vec* restrict rhs, global const vec* restrict coarse,
                    global vec* restrict solution, global vec* restrict scratch,
                    global accu_vec* restrict dots) {
  // Stages: black from the right-hand side (not with only_red), red with correction, black, red,
  // black; each one cell less around the tile, one plane later.
  const int lead = only_red ? 0 : 1;
  const Box relaxed = around(own, 1, nx, ny, nz);    // red
  const Box middle = around(own, 2, nx, ny, nz);     // black
  const Box corrected = around(own, 3, nx, ny, nz);  // red
  const Box first = around(own, 3 + lead, nx, ny, nz);
  const Ring ring = make_split_ring(scratch, 5 + lead, first);
  clear(ring.planes, ring.depth * ring.plane);
  global vec* zeros = scratch + ring.depth * ring.plane;
  clear(zeros, cx);
  // Of plane y, whose black cells come with the next t.
  accu_vec gamma_red = (accu_vec)(0), delta_red = (accu_vec)(0);
  for (int t = first.y0; t < own.y1 + 3 + lead; ++t) {
    if (t >= first.y1) clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    const int c = t - lead, m = t - 1 - lead, y = t - 2 - lead, d = t - 3 - lead;
    const accu_vec gamma = gamma_red;
    accu_vec delta = delta_red;
    gamma_red = delta_red = (accu_vec)(0);
    for (int k = first.z0; k < first.z1; ++k) {
      const int parity = PARITY(only_red ? RED : BLACK, t, k);
      const Span all = span_of(first, first.y0, k, parity);
      const Span firsts = span_of(first, t, k, parity), corrects = span_of(corrected, c, k, parity),
                 middles = span_of(middle, m, k, parity), relaxes = span_of(relaxed, y, k, parity),
                 owns = span_of(own, y, k, parity), lasts = span_of(own, d, k, parity);
      global vec* out0 = half_row(ring, t, k, parity);
      global vec* out_c = half_row(ring, c, k, parity);
      global vec* out_m = half_row(ring, m, k, parity);
      global vec* out = half_row(ring, y, k, parity);
      global vec* out_d = half_row(ring, d, k, parity);
      const Rows vc = rows_at(ring, c, k, parity), vm = rows_at(ring, m, k, parity),
                 v = rows_at(ring, y, k, parity), vd = rows_at(ring, d, k, parity);
      global const Stencil* g0 = stencils + STENCIL_ROW(t, k, parity);
      global const Stencil* gc = stencils + STENCIL_ROW(c, k, parity);
      global const Stencil* gm = stencils + STENCIL_ROW(m, k, parity);
      global const Stencil* g = stencils + STENCIL_ROW(y, k, parity);
      global const Stencil* gd = stencils + STENCIL_ROW(d, k, parity);
      global const Weights* w = weights + RED_ROW(c, k);
      global const vec* right0 = right_row(only_red, rhs, nx, ny, t, k, parity);
      global const vec* right_c = right_row(only_red, rhs, nx, ny, c, k, parity);
      global const vec* right_m = right_row(only_red, rhs, nx, ny, m, k, parity);
      global const vec* right = right_row(only_red, rhs, nx, ny, y, k, parity);
      global const vec* right_d = right_row(only_red, rhs, nx, ny, d, k, parity);
      global vec* to = solution + (only_red ? RED_ROW(y, k) : CELL(parity, d, k));
      const int inside = c >= 0 && c < ny;
      const Parents from = parents_at(inside ? c : 0, k, cx, cy, cz, half_y, half_z, coarse, zeros);
      const int ahead = min(t + 1, ny - 1);
      global const Stencil* next = stencils + STENCIL_ROW(ahead, k, 0);
      global const Weights* next_weights = weights + RED_ROW(ahead, k);
      global const vec* next_right = right_row(only_red, rhs, nx, ny, ahead, k, 0);
      vec sum = (vec)(0), energy = (vec)(0), energy_black = (vec)(0);
      for (long i = all.begin; i < all.end + 3 + lead; ++i) {
        PREFETCH(next_right + AT(i));
        if (!only_red) PREFETCH(next_right + 2 * i + 1);
        if (!only_red && WITHIN(firsts, i)) out0[i] = g0[i].smoother * right0[AT(i)];
        if (WITHIN(corrects, i - lead)) {
          const long e = i - lead;
          const vec driving = only_red ? right_c[AT(e)] : right_c[AT(e)] + INFLOW(gc[e], vc, e);
          out_c[e] = gc[e].smoother * driving +
                     interpolated(from, 2 * e + parity, cx, half_x, w[e].x, w[e].y, w[e].z);
        }
        PREFETCH_STENCILS(next, i);
        if (WITHIN(middles, i - 1 - lead)) {
          const long e = i - 1 - lead;
          out_m[e] = gm[e].smoother *
                     (only_red ? INFLOW(gm[e], vm, e) : right_m[AT(e)] + INFLOW(gm[e], vm, e));
        }
        if (WITHIN(relaxes, i - 2 - lead)) {
          const long e = i - 2 - lead;
          const vec here = out[e] + g[e].smoother * (right[AT(e)] - IMAGE(g[e], v, e));
          out[e] = here;
          if (only_red && WITHIN(owns, e)) {
            STREAM_OUT(here, to + e);
            sum += here * right[AT(e)];
            energy += g[e].sink * (here * here);
          }
        }
        PREFETCH(next_weights + i);
        if (WITHIN(lasts, i - 3 - lead)) {
          const long e = i - 3 - lead;
          if (only_red) {
            energy_black += black_energy(gd[e], vd, e);
          } else {
            out_d[e] = gd[e].smoother * (right_d[AT(e)] + INFLOW(gd[e], vd, e));
          }
        }
      }
      if (only_red && owns.begin < owns.end) {
#define ADD_SURFACE(face) \
  for (long e = owns.begin; e < owns.end; ++e) energy += g[e].face * (out[e] * out[e]);
        if (y == 0) ADD_SURFACE(south)
        if (y == ny - 1) ADD_SURFACE(north)
        if (k == 0) ADD_SURFACE(down)
        if (k == nz - 1) ADD_SURFACE(up)
#undef ADD_SURFACE
        if (own.x0 == 0 && parity == 0) energy += g[0].west * (out[0] * out[0]);
        const int last = nx - 1 - parity;
        if (own.x1 == nx && !(last & 1)) {
          energy += g[last >> 1].east * (out[last >> 1] * out[last >> 1]);
        }
      }
      if (only_red) {
        gamma_red += to_accu(sum);
        delta_red += to_accu(energy);
        delta += to_accu(energy_black);
      } else if (HAS_ROW(own, d, k)) {
        global vec* row = solution + CELL(0, d, k);
        global const vec *even = half_row(ring, d, k, 0), *uneven = half_row(ring, d, k, 1);
        for (int x = own.x0; x < own.x1; ++x) row[x] = x & 1 ? uneven[x >> 1] : even[x >> 1];
      }
    }
    if (only_red && d >= own.y0) {
      dots[2 * d] = gamma;
      dots[2 * d + 1] = delta;
    }
  }
}

kernel void stream_down(TILE_ARGUMENTS, const int only_red, GRID_ARGUMENTS, COARSE_ARGUMENTS,
                        global const vec* restrict rhs, global vec* restrict coarse,
                        const int scratch_cells, global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, cx, cy, cz);
  if (only_red) {
    down_tile(1, own, nx, ny, nz, stencils, cx, cy, cz, half_x, half_y, half_z, weights, rhs,
              coarse, TILE_SCRATCH);
  } else {
    down_tile(0, own, nx, ny, nz, stencils, cx, cy, cz, half_x, half_y, half_z, weights, rhs,
              coarse, TILE_SCRATCH);
  }
}

// dots [plane of a tile][2] (first_sum): γ and δ.
kernel void stream_up(TILE_ARGUMENTS, const int only_red, GRID_ARGUMENTS, COARSE_ARGUMENTS,
                      global const vec* restrict rhs, global const vec* restrict coarse,
                      global vec* restrict solution, global accu_vec* restrict dots,
                      const int scratch_cells, global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  if (only_red) {
    up_tile(1, own, nx, ny, nz, stencils, cx, cy, cz, half_x, half_y, half_z, weights, rhs, coarse,
            solution, TILE_SCRATCH, dots + 2 * first_sum(own, tile_x, tile_z, nx, ny));
  } else {
    up_tile(0, own, nx, ny, nz, stencils, cx, cy, cz, half_x, half_y, half_z, weights, rhs, coarse,
            solution, TILE_SCRATCH, dots);
  }
}

// The last level by the inverse of its matrix, [cell][cell].
kernel void solve_last(const int cells, global const REAL* restrict inverse,
                       global const vec* restrict rhs, global vec* restrict solution) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0) return;
  for (int i = 0; i < cells; ++i) {
    global const REAL* row = inverse + i * cells;
    vec sum = (vec)(0);
    for (int k = 0; k < cells; ++k) sum += row[k] * rhs[k];
    solution[i] = sum;
  }
}

// The cycle and its sums where the finest grid is a single cell already.
kernel void cycle_of_one_cell(global const Stencil* restrict g, global const vec* restrict rhs,
                              global vec* restrict solution, global accu_vec* restrict dots) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0) return;
  const REAL inverse = 1 / (g->west + g->east + g->south + g->north + g->down + g->up + g->sink);
  const vec z = inverse * rhs[0];
  solution[0] = z;
  dots[0] = to_accu(z * rhs[0]);
  dots[1] = to_accu(z * (z / inverse));
}
