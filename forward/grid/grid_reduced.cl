// The reduced system of grid_stream_prelude.cl in ACCU arithmetic: its true residual, and the way back from
// red cells to all of them. The solution is x + d: x on all cells, of which only the red ones are
// read, and a correction d on red cells in their own order; without with_d, d is taken for zero.
// Red is (x+y+z) even. One item per row and vector group where nothing else is said.

#define RED_SETUP                                                            \
  const int group = (int)get_global_id(0) % GROUPS;                          \
  const int segment = (int)get_global_id(0) / GROUPS;                        \
  const int row = (int)get_global_id(1);                                     \
  const int x_begin = segment * SEGMENT, x_end = min(nx, x_begin + SEGMENT); \
  if (x_begin >= nx || row >= ny * nz) return;                               \
  const int y = row % ny, z = row / ny;

typedef struct {
  int nx, ny, nz, group, with_d;
  global const REAL *gx, *gy, *gz, *sink;
  global const vec *x, *d, *rhs;
} Reduced;

// φ of a red cell, 0 outside the grid.
inline __attribute__((always_inline)) accu_vec red_value(Reduced s, int x, int y, int z) {
  if (x < 0 || x >= s.nx || y < 0 || y >= s.ny || z < 0 || z >= s.nz) return (accu_vec)(0);
  const size_t row = (size_t)z * s.ny + y;
  const accu_vec value = to_accu(s.x[(row * s.nx + x) * GROUPS + s.group]);
  if (!s.with_d) return value;
  return value + to_accu(s.d[(row * ((s.nx + 1) >> 1) + (x >> 1)) * GROUPS + s.group]);
}

// φ = (b + Σ G φ_neighbour) / D of a black cell, 0 outside the grid.
inline __attribute__((always_inline)) accu_vec black_value(Reduced s, int x, int y, int z) {
  if (x < 0 || x >= s.nx || y < 0 || y >= s.ny || z < 0 || z >= s.nz) return (accu_vec)(0);
  const size_t row = (size_t)z * s.ny + y, i = row * s.nx + x;
  const ACCU west = s.gx[row * (s.nx + 1) + x], east = s.gx[row * (s.nx + 1) + x + 1];
  const size_t face = ((size_t)z * (s.ny + 1) + y) * s.nx + x;
  const ACCU south = s.gy[face], north = s.gy[face + s.nx];
  const ACCU down = s.gz[i], up = s.gz[i + (size_t)s.nx * s.ny];
  const accu_vec inflow = west * red_value(s, x - 1, y, z) + east * red_value(s, x + 1, y, z) +
                          south * red_value(s, x, y - 1, z) + north * red_value(s, x, y + 1, z) +
                          down * red_value(s, x, y, z - 1) + up * red_value(s, x, y, z + 1);
  return (to_accu(s.rhs[i * GROUPS + s.group]) + inflow) *
         (1 / (west + east + south + north + down + up + (ACCU)s.sink[i]));
}

#define REDUCED_ARGUMENTS                                                               \
  const int nx, const int ny, const int nz, global const REAL *restrict gx,             \
      global const REAL *restrict gy, global const REAL *restrict gz,                   \
      global const REAL *restrict sink, const int with_d, global const vec *restrict d, \
      global const vec *restrict rhs

// Black cells of x from its red ones.
kernel void solve_black(REDUCED_ARGUMENTS, global vec* x) {
  RED_SETUP
  const Reduced s = {nx, ny, nz, group, with_d, gx, gy, gz, sink, x, d, rhs};
  for (int i = x_begin + ((x_begin ^ y ^ z ^ 1) & 1); i < x_end; i += 2) {
    x[((size_t)row * nx + i) * GROUPS + group] = to_vec(black_value(s, i, y, z));
  }
}

// r = b − A (x + d) on red cells, black ones solved for; sums [item][2][GROUPS]: Σ r² and Σ b² over
// all cells of an item's run of planes y. The item keeps the last three planes of black values,
// [y mod 3][z][x >> 1], in its part of `scratch`.
kernel void reduced_residual(REDUCED_ARGUMENTS, const int planes, global const vec* restrict x,
                             global vec* restrict r, global accu_vec* restrict sums,
                             global accu_vec* restrict scratch) {
  const int group = (int)get_global_id(0), item = (int)get_global_id(1);
  if (group >= GROUPS || item * planes >= ny) return;
  const Reduced s = {nx, ny, nz, group, with_d, gx, gy, gz, sink, x, d, rhs};
  const int row_reds = (nx + 1) >> 1;
  scratch += ((size_t)item * GROUPS + group) * 3 * nz * row_reds;
#define KEPT(x, y, z) scratch[((size_t)(((y) + 3) % 3) * nz + (z)) * row_reds + ((x) >> 1)]
  accu_vec rr = (accu_vec)(0), bb = (accu_vec)(0);
  const int begin = item * planes, end = min(begin + planes, ny);
  for (int t = max(begin - 1, 0); t <= end; ++t) {
    if (t < ny) {
      for (int k = 0; k < nz; ++k) {
        for (int i = (t ^ k ^ 1) & 1; i < nx; i += 2) KEPT(i, t, k) = black_value(s, i, t, k);
      }
    }
    const int y = t - 1;
    if (y < begin) continue;
    for (int k = 0; k < nz; ++k) {
      const size_t row = (size_t)k * ny + y;
      global const REAL* across_x = gx + row * (nx + 1);
      global const REAL* across_y = gy + ((size_t)k * (ny + 1) + y) * nx;
      global const REAL* across_z = gz + row * nx;
      for (int i = (y ^ k) & 1; i < nx; i += 2) {
        const accu_vec zero = (accu_vec)(0), here = red_value(s, i, y, k);
        const accu_vec west = i > 0 ? KEPT(i - 1, y, k) : zero;
        const accu_vec east = i + 1 < nx ? KEPT(i + 1, y, k) : zero;
        const accu_vec south = y > 0 ? KEPT(i, y - 1, k) : zero;
        const accu_vec north = y + 1 < ny ? KEPT(i, y + 1, k) : zero;
        const accu_vec down = k > 0 ? KEPT(i, y, k - 1) : zero;
        const accu_vec up = k + 1 < nz ? KEPT(i, y, k + 1) : zero;
        const accu_vec image =
            (ACCU)across_x[i] * (here - west) + (ACCU)across_x[i + 1] * (here - east) +
            (ACCU)across_y[i] * (here - south) + (ACCU)across_y[i + nx] * (here - north) +
            (ACCU)across_z[i] * (here - down) + (ACCU)across_z[i + nx * ny] * (here - up) +
            (ACCU)sink[row * nx + i] * here;
        const accu_vec residual = to_accu(rhs[(row * nx + i) * GROUPS + group]) - image;
        r[(row * row_reds + (i >> 1)) * GROUPS + group] = to_vec(residual);
        rr += residual * residual;
      }
      for (int i = 0; i < nx; ++i) {
        const accu_vec right = to_accu(rhs[(row * nx + i) * GROUPS + group]);
        bb += right * right;
      }
    }
  }
#undef KEPT
  sums[2 * item * GROUPS + group] = rr;
  sums[(2 * item + 1) * GROUPS + group] = bb;
}

// x + d anew on red cells, as the nearest x and what that leaves over (Knuth's two-sum).
kernel void renormalise_red(const int nx, const int ny, const int nz, global vec* restrict x,
                            global vec* restrict d) {
  RED_SETUP
  for (int i = x_begin + ((x_begin ^ y ^ z) & 1); i < x_end; i += 2) {
    const size_t k = ((size_t)row * nx + i) * GROUPS + group;
    const size_t e = ((size_t)row * ((nx + 1) >> 1) + (i >> 1)) * GROUPS + group;
    const vec high = x[k] + d[e], shift = high - x[k];
    d[e] = (x[k] - (high - shift)) + (d[e] - shift);
    x[k] = high;
  }
}
