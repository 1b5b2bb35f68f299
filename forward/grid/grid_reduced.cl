// The reduced system in ACCU arithmetic: its true residual, as a sweep (grid_stream_prelude.cl) whose
// ring holds ACCU vectors, and with it the way back from red cells to all of them. The solution is
// x + d: x on all cells, of which only the red ones are read, and a correction d on red cells in
// their own order; without with_d, d is taken for zero.

// r = b − A (x + d) on red cells, black ones solved for and written to `black`, which may be x; sums
// [tile][2]: Σ r² and Σ b² over all cells of each tile.
kernel void reduced_residual(TILE_ARGUMENTS, GRID_ARGUMENTS, global const REAL* restrict sink,
                             const int with_d, global const vec* restrict d,
                             global const vec* restrict rhs, global const vec* x, global vec* black,
                             global vec* restrict r, global accu_vec* restrict sums,
                             const int scratch_cells, global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  const Box blacks = around(own, 1, nx, ny, nz), reds = around(own, 2, nx, ny, nz);
  const Ring ring = make_ring((global ring_vec*)(TILE_SCRATCH), 4, reds);
  clear(ring.planes, ring.depth * ring.plane);
  accu_vec rr = (accu_vec)(0), bb = (accu_vec)(0);
  for (int t = reds.y0; t < own.y1 + 2; ++t) {
    if (t < reds.y1) {
      for (int k = reds.z0; k < reds.z1; ++k) {
        global const vec* from = x + CELL(0, t, k);
        global const vec* more = d + RED_CELL(0, t, k);
        global ring_vec* out = ring_row(ring, t, k);
        for (int i = FIRST(reds.x0, RED, t, k); i < reds.x1; i += 2) {
          out[i] = with_d ? to_accu(from[i]) + to_accu(more[i >> 1]) : to_accu(from[i]);
        }
      }
    } else {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
    }
    if (t - 1 >= blacks.y0 && t - 1 < blacks.y1) {
      for (int k = blacks.z0; k < blacks.z1; ++k) {
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, t - 1, k);
        const Rows v = rows_at(ring, t - 1, k);
        const size_t row = CELL(0, t - 1, k);
        const int inside = t - 1 >= own.y0 && t - 1 < own.y1 && k >= own.z0 && k < own.z1;
        global ring_vec* out = ring_row(ring, t - 1, k);
        // What comes next is fetched meanwhile: b for this stage's next plane, the others one ahead.
        const int ahead = min(t + 1, ny - 1), next = min(t, ny - 1);
        const Coming coming = coming_row(nx, ny, ahead, k, gx, gy, gz, sink, sink);
        global const vec* coming_x = x + CELL(0, ahead, k);
        global const vec* coming_d = d + RED_CELL(0, ahead, k);
        global const vec* coming_rhs = rhs + CELL(0, next, k);
        for (int i = FIRST(blacks.x0, BLACK, t - 1, k); i < blacks.x1; i += 2) {
          fetch_coming(&coming, i);
          PREFETCH(coming_x + (i ^ 1));
          PREFETCH(coming_d + (i >> 1));
          PREFETCH(coming_rhs + i);
          PREFETCH(coming_rhs + (i ^ 1));
          const ACCU sum = (ACCU)g.gx[i] + g.gx[i + 1] + g.gy[i] + g.gy_north[i] + g.gz[i] +
                           g.gz_up[i] + sink[row + i];
          const accu_vec right = to_accu(rhs[row + i]);
          const accu_vec value = (right + INFLOW(g, v, i)) * (1 / sum);
          out[i] = value;
          if (!inside || i < own.x0 || i >= own.x1) continue;
          STREAM_OUT(to_vec(value), black + row + i);
          bb += right * right;
        }
      }
    }
    const int y = t - 2;
    if (y < own.y0 || y >= own.y1) continue;
    for (int k = own.z0; k < own.z1; ++k) {
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, k);
      const Rows v = rows_at(ring, y, k);
      const size_t row = CELL(0, y, k), red = RED_CELL(0, y, k);
      for (int i = FIRST(own.x0, RED, y, k); i < own.x1; i += 2) {
        const accu_vec right = to_accu(rhs[row + i]);
        const accu_vec image = OUTFLOW(g, v, i) + sink[row + i] * v.here[i];
        const accu_vec residual = right - image;
        STREAM_OUT(to_vec(residual), r + red + (i >> 1));
        rr += residual * residual;
        bb += right * right;
      }
    }
  }
  sums[2 * tile] = rr;
  sums[2 * tile + 1] = bb;
}

// The same where x + d is zero, to REAL's rounding: r = b_r + Σ G b_b / D. Tiles without a rim.
kernel void residual_of_zero(TILE_ARGUMENTS, GRID_ARGUMENTS, global const REAL* restrict inverse,
                             global const vec* restrict rhs, global vec* restrict black,
                             global vec* restrict r, global accu_vec* restrict sums) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  const size_t plane = (size_t)nx * ny;
  accu_vec rr = (accu_vec)(0), bb = (accu_vec)(0);
#define BLACK_AT(i) (inverse[i] * rhs[i])
  for (int y = own.y0; y < own.y1; ++y) {
    for (int k = own.z0; k < own.z1; ++k) {
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, k);
      for (int x = own.x0; x < own.x1; ++x) {
        const size_t i = CELL(x, y, k);
        const accu_vec right = to_accu(rhs[i]);
        bb += right * right;
        if ((x ^ y ^ k) & 1) {
          STREAM_OUT(BLACK_AT(i), black + i);
          continue;
        }
        vec inflow = (vec)(0);
        if (x > 0) inflow += g.gx[x] * BLACK_AT(i - 1);
        if (x + 1 < nx) inflow += g.gx[x + 1] * BLACK_AT(i + 1);
        if (y > 0) inflow += g.gy[x] * BLACK_AT(i - nx);
        if (y + 1 < ny) inflow += g.gy_north[x] * BLACK_AT(i + nx);
        if (k > 0) inflow += g.gz[x] * BLACK_AT(i - plane);
        if (k + 1 < nz) inflow += g.gz_up[x] * BLACK_AT(i + plane);
        const accu_vec residual = right + to_accu(inflow);
        STREAM_OUT(to_vec(residual), r + RED_CELL(x, y, k));
        rr += residual * residual;
      }
    }
  }
#undef BLACK_AT
  sums[2 * tile] = rr;
  sums[2 * tile + 1] = bb;
}

// x + d anew on red cells, as the nearest x and what that leaves over (Knuth's two-sum). One item per
// row.
kernel void renormalise_red(const int nx, const int ny, const int nz, global vec* restrict x,
                            global vec* restrict d) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  x += CELL(0, y, z);
  d += RED_CELL(0, y, z);
  for (int i = FIRST(0, RED, y, z); i < nx; i += 2) {
    const int e = i >> 1;
    const vec high = x[i] + d[e], shift = high - x[i];
    d[e] = (x[i] - (high - shift)) + (d[e] - shift);
    x[i] = high;
  }
}
