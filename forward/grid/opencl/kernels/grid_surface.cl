// What goes in and out of the block, and the sums a gradient is made of. Fields are
// [z][y][x][GROUPS] vectors; face samples [v][u][GROUPS]. A face is told by affine indices: its
// sample (u, v) touches cell `cell + u cell_u + v cell_v` of rows of nx cells; the face is the
// `side`th of the cell's stencil.

#define FACE_SETUP                                                                              \
  const int group = (int)get_global_id(0);                                                      \
  const int k = (int)get_global_id(1);                                                          \
  if (group >= GROUPS || k >= nu * nv) return;                                                  \
  const int u = k % nu, v = k / nu, at = cell + u * cell_u + v * cell_v, x = at % nx;           \
  const size_t i = (size_t)at * GROUPS + group;                                                 \
  global const Stencil* of_cell = stencils + ((size_t)(at / nx) * 2 + (x & 1)) * HALF + x / 2;  \
  const REAL conductance = ((global const REAL*)of_cell)[side];

#define FACE_ARGUMENTS                                                                          \
  const int nu, const int nv, const int cell, const int cell_u, const int cell_v, const int nx, \
      const int side, global const Stencil *restrict stencils

// b += scale G value on the face's cells.
kernel void add_on_face(FACE_ARGUMENTS, const REAL scale, global const vec* restrict value,
                        global vec* restrict b) {
  FACE_SETUP
  b[i] += (scale * conductance) * value[k * GROUPS + group];
}

// out = scale G (φ − q E) + apart E.
kernel void exitance(FACE_ARGUMENTS, const REAL scale, const REAL q, const REAL apart,
                     global const vec* restrict irradiance, global const vec* restrict phi,
                     global vec* restrict out) {
  FACE_SETUP
  const vec e = irradiance[k * GROUPS + group];
  out[k * GROUPS + group] = (scale * conductance) * (phi[i] - q * e) + apart * e;
}

// First collisions: b = deposit E(column), column = x a_x + y a_y + z a_z.
kernel void deposit(const int nx, const int ny, const int nz, const int a_x, const int a_y,
                    const int a_z, global const REAL* restrict fraction,
                    global const vec* restrict irradiance, global vec* restrict b) {
  FOR_ROW
  const int column = (row % ny) * a_y + (row / ny) * a_z;
  for (int x = begin; x < end; ++x) {
    const size_t i = (size_t)row * nx + x;
    b[i * GROUPS + group] = fraction[i] * irradiance[(column + x * a_x) * GROUPS + group];
  }
}

// Σ over lanes of a·b for fields read as scalars, first lanes only: padding lanes are zero anyway.
ACCU sum_lanes(global const REAL* a, global const REAL* b, size_t i) {
  ACCU sum = 0;
  for (int m = 0; m < LANES; ++m) sum += (ACCU)a[i * LANES + m] * (ACCU)b[i * LANES + m];
  return sum;
}
// Σ over lanes of (a_i − a_j)(b_i − b_j).
ACCU sum_lanes_across(global const REAL* a, global const REAL* b, size_t i, size_t j) {
  ACCU sum = 0;
  for (int m = 0; m < LANES; ++m) {
    sum +=
        (ACCU)(a[i * LANES + m] - a[j * LANES + m]) * (ACCU)(b[i * LANES + m] - b[j * LANES + m]);
  }
  return sum;
}

// PairProducts of one batch, added to what earlier batches left.
kernel void pair_products(const int nx, const int ny, const int nz, global const REAL* restrict a,
                          global const REAL* restrict b, global ACCU* restrict cell,
                          global ACCU* restrict face_x, global ACCU* restrict face_y,
                          global ACCU* restrict face_z) {
  FOR_SCALAR_ROW
  const int y = row % ny, z = row / ny;
  for (int x = begin; x < end; ++x) {
    const size_t i = (size_t)row * nx + x;
    cell[i] += sum_lanes(a, b, i);
    if (x + 1 < nx) face_x[i] += sum_lanes_across(a, b, i, i + 1);
    if (y + 1 < ny) face_y[i] += sum_lanes_across(a, b, i, i + nx);
    if (z + 1 < nz) face_z[i] += sum_lanes_across(a, b, i, i + (size_t)nx * ny);
  }
}

// sum += Σ over lanes of a · E(column); arguments as in deposit().
kernel void column_products(const int nx, const int ny, const int nz, const int a_x, const int a_y,
                            const int a_z, global const REAL* restrict a,
                            global const REAL* restrict irradiance, global ACCU* restrict sum) {
  FOR_SCALAR_ROW
  const int column = (row % ny) * a_y + (row / ny) * a_z;
  for (int x = begin; x < end; ++x) {
    const size_t i = (size_t)row * nx + x;
    ACCU total = 0;
    for (int m = 0; m < LANES; ++m) {
      total += (ACCU)a[i * LANES + m] * (ACCU)irradiance[(size_t)(column + x * a_x) * LANES + m];
    }
    sum[i] += total;
  }
}

// partial[row] = Σ_x w φ. One item per row.
kernel void weighted_rows(const int nx, const int rows, global const REAL* restrict weight,
                          global const vec* restrict phi, global accu_vec* restrict partial) {
  const int group = (int)get_global_id(0);
  const int row = (int)get_global_id(1);
  if (group >= GROUPS || row >= rows) return;
  accu_vec sum = (accu_vec)(0);
  for (size_t i = (size_t)row * nx; i < (size_t)(row + 1) * nx; ++i) {
    sum += (ACCU)weight[i] * to_accu(phi[i * GROUPS + group]);
  }
  partial[row * GROUPS + group] = sum;
}

// b = δb − δA φ: `source` per irradiance of the column (arguments as in deposit()), the changes of
// face conductances towards + and of the diagonal, all [z][y][x].
kernel void change_source(const int nx, const int ny, const int nz, const int a_x, const int a_y,
                          const int a_z, global const REAL* restrict source,
                          global const REAL* restrict diagonal, global const REAL* restrict face_x,
                          global const REAL* restrict face_y, global const REAL* restrict face_z,
                          global const vec* restrict irradiance, global const vec* restrict phi,
                          global vec* restrict b) {
  FOR_ROW
  const int y = row % ny, z = row / ny, column = y * a_y + z * a_z;
  const size_t plane = (size_t)nx * ny;
  for (int x = begin; x < end; ++x) {
    const size_t i = (size_t)row * nx + x;
    const vec here = phi[i * GROUPS + group];
    vec sum = source[i] * irradiance[(column + x * a_x) * GROUPS + group] - diagonal[i] * here;
    if (x > 0) sum -= face_x[i - 1] * (here - phi[(i - 1) * GROUPS + group]);
    if (x + 1 < nx) sum -= face_x[i] * (here - phi[(i + 1) * GROUPS + group]);
    if (y > 0) sum -= face_y[i - nx] * (here - phi[(i - nx) * GROUPS + group]);
    if (y + 1 < ny) sum -= face_y[i] * (here - phi[(i + nx) * GROUPS + group]);
    if (z > 0) sum -= face_z[i - plane] * (here - phi[(i - plane) * GROUPS + group]);
    if (z + 1 < nz) sum -= face_z[i] * (here - phi[(i + plane) * GROUPS + group]);
    b[i * GROUPS + group] = sum;
  }
}
