// The reduced system in ACCU arithmetic: its true residual, as a sweep (grid_stream_prelude.cl)
// whose ring holds ACCU vectors, and with it the way back from red cells to all of them. The
// solution is x + d: x on all cells, of which only the red ones are read, and a correction d on red
// cells in their own order.

// Which of the two are there: x and d; x, whatever d holds; or d, which x is set to.
#define X_AND_D 0
#define X_ALONE 1
#define D_ALONE 2

// r = b − A (x + d) on red cells, black ones solved for and written to x;
// sums [plane of a tile][2] (first_sum): Σ r² and Σ b² over all cells.
kernel void reduced_residual(TILE_ARGUMENTS, GRID_ARGUMENTS, const int parts,
                             global const vec* restrict d, global const vec* restrict rhs,
                             global vec* restrict x, global vec* restrict r,
                             global accu_vec* restrict sums, const int scratch_cells,
                             global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  const Box blacks = around(own, 1, nx, ny, nz), reds = around(own, 2, nx, ny, nz);
  const Ring ring = make_split_ring((global ring_vec*)(TILE_SCRATCH), 4, reds);
  clear(ring.planes, ring.depth * ring.plane);
  sums += 2 * first_sum(own, tile_x, tile_z, nx, ny);
  accu_vec bb_black = (accu_vec)(0);  // of plane t − 1, whose red cells come with the next t
  for (int t = reds.y0; t < own.y1 + 2; ++t) {
    accu_vec rr = (accu_vec)(0), bb = bb_black;
    bb_black = (accu_vec)(0);
    if (t >= reds.y1) clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    for (int k = reds.z0; k < reds.z1; ++k) {
      const int parity = PARITY(RED, t, k), m = t - 1, y = t - 2;
      const Span all = span_of(reds, reds.y0, k, parity), firsts = span_of(reds, t, k, parity),
                 middles = span_of(blacks, m, k, parity), writes = span_of(own, m, k, parity),
                 owns = span_of(own, y, k, parity);
      global const vec* from = x + CELL(parity, t, k);
      global const vec* more = d + RED_ROW(t, k);
      global ring_vec* out0 = half_row(ring, t, k, parity);
      global ring_vec* out = half_row(ring, m, k, parity);
      const Rows vm = rows_at(ring, m, k, parity), v = rows_at(ring, y, k, parity);
      global const Stencil* gm = stencils + STENCIL_ROW(m, k, parity);
      global const Stencil* g = stencils + STENCIL_ROW(y, k, parity);
      global const vec* right_m = rhs + CELL(parity, m, k);
      global const vec* right = rhs + CELL(parity, y, k);
      global vec* to_black = x + CELL(parity, m, k);
      global vec* to_red = x + CELL(parity, y, k);
      global vec* to = r + RED_ROW(y, k);
      // What comes next is fetched meanwhile, one plane ahead.
      const int ahead = min(t + 1, ny - 1), next = min(t, ny - 1);
      global const Stencil* coming = stencils + STENCIL_ROW(ahead, k, 0);
      global const vec* coming_x = x + CELL(PARITY(RED, ahead, k), ahead, k);
      global const vec* coming_d = d + RED_ROW(ahead, k);
      global const vec* coming_rhs = rhs + CELL(0, next, k);
      for (long e = all.begin; e < all.end; ++e) {
        if (parts != D_ALONE) PREFETCH(coming_x + 2 * e);
        PREFETCH(coming_d + e);
        if (WITHIN(firsts, e)) {
          out0[e] = parts == D_ALONE   ? to_accu(more[e])
                    : parts == X_ALONE ? to_accu(from[2 * e])
                                       : to_accu(from[2 * e]) + to_accu(more[e]);
        }
        PREFETCH_STENCILS(coming, e);
        if (WITHIN(middles, e)) {
          const Stencil s = gm[e];
          const ACCU sum = (ACCU)s.west + s.east + s.south + s.north + s.down + s.up + s.sink;
          const accu_vec here = to_accu(right_m[2 * e]);
          const accu_vec value = (here + INFLOW(s, vm, e)) * (1 / sum);
          out[e] = value;
          if (WITHIN(writes, e)) {
            STREAM_OUT(to_vec(value), to_black + 2 * e);
            bb_black += here * here;
          }
        }
        PREFETCH(coming_rhs + 2 * e);
        PREFETCH(coming_rhs + 2 * e + 1);
        if (WITHIN(owns, e)) {
          const accu_vec here = to_accu(right[2 * e]);
          const accu_vec residual = here - IMAGE(g[e], v, e);
          STREAM_OUT(to_vec(residual), to + e);
          if (parts == D_ALONE) STREAM_OUT(to_vec(v.here[e]), to_red + 2 * e);
          rr += residual * residual;
          bb += here * here;
        }
      }
    }
    if (t - 2 < own.y0) continue;
    sums[2 * (t - 2)] = rr;
    sums[2 * (t - 2) + 1] = bb;
  }
}

// The same where x + d is zero, whatever x holds, to REAL's rounding: r = b_r + Σ G b_b / D. Tiles
// without a rim.
kernel void residual_of_zero(TILE_ARGUMENTS, GRID_ARGUMENTS, global const vec* restrict rhs,
                             global vec* restrict x_out, global vec* restrict r,
                             global accu_vec* restrict sums) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  const size_t plane = (size_t)nx * ny;
  sums += 2 * first_sum(own, tile_x, tile_z, nx, ny);
// The smoother of a black cell is 1 / D. Cell i is x of row (y, z).
#define BLACK_AT(i, x, y, z) (stencils[STENCIL_ROW(y, z, (x)&1) + ((x) >> 1)].smoother * rhs[i])
  for (int y = own.y0; y < own.y1; ++y) {
    accu_vec rr = (accu_vec)(0), bb = (accu_vec)(0);
    for (int k = own.z0; k < own.z1; ++k) {
      const int red = PARITY(RED, y, k);
      global const Stencil* g = stencils + STENCIL_ROW(y, k, red);
      global vec* to = r + RED_ROW(y, k);
      for (int x = own.x0; x < own.x1; ++x) {
        const size_t i = CELL(x, y, k);
        const accu_vec right = to_accu(rhs[i]);
        bb += right * right;
        if ((x ^ red) & 1) {
          STREAM_OUT(BLACK_AT(i, x, y, k), x_out + i);
          continue;
        }
        STREAM_OUT((vec)(0), x_out + i);
        const Stencil s = g[x >> 1];
        vec inflow = (vec)(0);
        if (x > 0) inflow += s.west * BLACK_AT(i - 1, x - 1, y, k);
        if (x + 1 < nx) inflow += s.east * BLACK_AT(i + 1, x + 1, y, k);
        if (y > 0) inflow += s.south * BLACK_AT(i - nx, x, y - 1, k);
        if (y + 1 < ny) inflow += s.north * BLACK_AT(i + nx, x, y + 1, k);
        if (k > 0) inflow += s.down * BLACK_AT(i - plane, x, y, k - 1);
        if (k + 1 < nz) inflow += s.up * BLACK_AT(i + plane, x, y, k + 1);
        const accu_vec residual = right + to_accu(inflow);
        STREAM_OUT(to_vec(residual), to + (x >> 1));
        rr += residual * residual;
      }
    }
    sums[2 * y] = rr;
    sums[2 * y + 1] = bb;
  }
#undef BLACK_AT
}

// x + d anew on red cells, as the nearest x and what that leaves over (Knuth's two-sum). One item
// per row.
kernel void renormalise_red(const int nx, const int ny, const int nz, global vec* restrict x,
                            global vec* restrict d) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  const int parity = PARITY(RED, y, z);
  x += CELL(parity, y, z);
  d += RED_ROW(y, z);
  for (int e = 0; 2 * e + parity < nx; ++e) {
    const vec high = x[2 * e] + d[e], shift = high - x[2 * e];
    d[e] = (x[2 * e] - (high - shift)) + (d[e] - shift);
    x[2 * e] = high;
  }
}
