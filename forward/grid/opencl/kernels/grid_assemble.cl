// Conductances of the finest level from κ and μ, and what each level keeps beside its conductances.
// All arrays are scalar, layouts as in grid_operator.cl. One item per row (y, z), or on GPUs per
// cell of it.

// Boundary faces; 0 on mirrors.
REAL robin(REAL kappa, REAL h, REAL A, int open) {
  return open ? robin_conductance(kappa, h, A) : (REAL)0;
}
REAL harmonic(REAL a, REAL b, REAL h) {
  return h * 2 * (a * b / (a + b));
}

// open_x, open_y, open_z: whether the faces across that axis are open.
kernel void assemble(const int nx, const int ny, const int nz, const REAL h, const REAL A,
                     const int open_x, const int open_y, const int open_z,
                     global const REAL* restrict kappa, global const REAL* restrict mu,
                     global REAL* restrict gx, global REAL* restrict gy, global REAL* restrict gz,
                     global REAL* restrict sink) {
  FOR_SCALAR_ROW
  const int y = row % ny, z = row / ny;
  const size_t first = (size_t)row * nx;
  const size_t plane = (size_t)nx * ny;
  global REAL* face_x = gx + (size_t)row * (nx + 1);
  global REAL* face_y = gy + ((size_t)z * (ny + 1) + y) * nx;
  FOR_CELLS(x, 0, nx) {
    const size_t i = first + x;
    const REAL k = kappa[i];
    sink[i] = mu[i] * h * h * h;
    face_x[x] = x > 0 ? harmonic(kappa[i - 1], k, h) : robin(k, h, A, open_x);
    face_y[x] = y > 0 ? harmonic(kappa[i - nx], k, h) : robin(k, h, A, open_y);
    gz[i] = z > 0 ? harmonic(kappa[i - plane], k, h) : robin(k, h, A, open_z);
    if (x == nx - 1) face_x[nx] = robin(k, h, A, open_x);
    if (y == ny - 1) face_y[x + nx] = robin(k, h, A, open_y);
    if (z == nz - 1) gz[i + plane] = robin(k, h, A, open_z);
  }
}

// 1 / D, D = Σ G + S of each cell, and how loosely it holds the node of its coarse cell, D^(−5/8)
// (to_node).
kernel void invert_diagonal(const int nx, const int ny, const int nz,
                            global const REAL* restrict gx, global const REAL* restrict gy,
                            global const REAL* restrict gz, global const REAL* restrict sink,
                            global REAL* restrict inverse, global REAL* restrict loose) {
  FOR_SCALAR_ROW
  const int y = row % ny, z = row / ny;
  gx += (size_t)row * (nx + 1);
  gy += ((size_t)z * (ny + 1) + y) * nx;
  gz += (size_t)row * nx;
  FOR_CELLS(x, 0, nx) {
    const size_t i = (size_t)row * nx + x;
    const REAL d = gx[x] + gx[x + 1] + gy[x] + gy[x + nx] + gz[x] + gz[x + nx * ny] + sink[i];
    inverse[i] = 1 / d;
    const REAL root = sqrt(inverse[i]);
    loose[i] = root * sqrt(sqrt(root));
  }
}

// Σ over the children: coarse S, and the faces across an axis that is not halved. n and c: extents
// of the fine and the coarse array.
kernel void sum_children(const int nx, const int ny, const int nz, const int cx, const int cy,
                         const int cz, const int half_x, const int half_y, const int half_z,
                         global const REAL* restrict fine, global REAL* restrict coarse) {
  FOR_ROW_OF(cx, cy * cz)
  const int cell_y = row % cy, cell_z = row / cy;
  FOR_CELLS(cell_x, 0, cx) {
    REAL sum = 0;
    for (int z = cell_z << half_z; z < min((cell_z + 1) << half_z, nz); ++z) {
      for (int y = cell_y << half_y; y < min((cell_y + 1) << half_y, ny); ++y) {
        for (int x = cell_x << half_x; x < min((cell_x + 1) << half_x, nx); ++x) {
          sum += fine[((size_t)z * ny + y) * nx + x];
        }
      }
    }
    coarse[(size_t)row * cx + cell_x] = sum;
  }
}

// Σ (G₋ + G₊) / D over the cells of a row, for each axis: where a cell's flux can go. ROW_ITEMS
// items per row; shares [row][3].
#define ROW_ITEMS (SEGMENT == 1 ? 32 : 1)
kernel __attribute__((reqd_work_group_size(ROW_ITEMS, 1, 1))) void axis_shares(
    const int nx, const int ny, const int nz, global const REAL* restrict gx,
    global const REAL* restrict gy, global const REAL* restrict gz,
    global const REAL* restrict inverse, global ACCU* restrict shares) {
  const int row = (int)get_global_id(1), item = (int)get_local_id(0);
  const int y = row % ny, z = row / ny;
  gx += (size_t)row * (nx + 1);
  gy += ((size_t)z * (ny + 1) + y) * nx;
  gz += (size_t)row * nx;
  inverse += (size_t)row * nx;
  ACCU along_x = 0, along_y = 0, along_z = 0;
  for (int x = item; x < nx; x += ROW_ITEMS) {
    along_x += (gx[x] + gx[x + 1]) * inverse[x];
    along_y += (gy[x] + gy[x + nx]) * inverse[x];
    along_z += (gz[x] + gz[x + nx * ny]) * inverse[x];
  }
  local ACCU sums[ROW_ITEMS][3];
  sums[item][0] = along_x;
  sums[item][1] = along_y;
  sums[item][2] = along_z;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item > 0) return;
  for (int axis = 0; axis < 3; ++axis) {
    ACCU sum = sums[0][axis];
    for (int other = 1; other < ROW_ITEMS; ++other) sum += sums[other][axis];
    shares[3 * row + axis] = sum;
  }
}

// sum[x] += g[x] others[x] / D[x] for an item's cells from `first` on, before `last`: what the bond
// g to a neighbour adds to the diagonal of the reduced system, D being the neighbour's and `others`
// its sink and its faces a to e but that one.
inline __attribute__((always_inline)) void add_bonds(
    const int begin, const int end, const int first, const int last, global REAL* restrict sum,
    global const REAL* restrict g, global const REAL* restrict inverse,
    global const REAL* restrict sink, global const REAL* restrict a, global const REAL* restrict b,
    global const REAL* restrict c, global const REAL* restrict d, global const REAL* restrict e) {
  FOR_CELLS(x, first, last) {
    const REAL others = sink[x] + a[x] + b[x] + c[x] + d[x] + e[x];
    sum[x] += g[x] * (others * inverse[x]);
  }
}

inline __attribute__((always_inline)) void add_faces(const int begin, const int end,
                                                     const int first, const int last,
                                                     global REAL* restrict sum,
                                                     global const REAL* restrict g) {
  FOR_CELLS(x, first, last) sum[x] += g[x];
}

// What relaxes a level (grid_stream_prelude.cl): 1 / D on black cells, ω / S_ii on red ones, with
// S_ii = S + Σ G (1 − G / D_neighbour) the diagonal of the reduced system. D_neighbour − G is
// summed from the neighbour's other parts, since it may be far smaller than both. With ω = 5/6 the
// sweep is Gauss-Seidel's in a uniform medium; below 1 the cycle is sure to be positive definite,
// because the eigenvalues of S scaled by its diagonal lie in (0, 2]. One face at a time along the
// whole row, so that no loop has a branch; black cells are computed in vain.
kernel void make_smoother(const int nx, const int ny, const int nz, const REAL omega,
                          global const REAL* restrict gx, global const REAL* restrict gy,
                          global const REAL* restrict gz, global const REAL* restrict sink,
                          global const REAL* restrict inverse, global REAL* restrict smoother) {
  FOR_SCALAR_ROW
  const int y = row % ny, z = row / ny;
  // From a row to the next along y and z: cells, faces across x, y and z.
  const size_t plane = (size_t)nx * ny, plane_x = (size_t)(nx + 1) * ny,
               plane_y = (size_t)nx * (ny + 1);
  gx += (size_t)row * (nx + 1);
  gy += z * plane_y + (size_t)y * nx;
  gz += (size_t)row * nx;
  sink += (size_t)row * nx;
  inverse += (size_t)row * nx;
  smoother += (size_t)row * nx;
  FOR_CELLS(x, 0, nx) smoother[x] = sink[x];
  add_faces(begin, end, 0, 1, smoother, gx);
  add_bonds(begin, end, 1, nx, smoother, gx, inverse - 1, sink - 1, gx - 1, gy - 1, gy + nx - 1,
            gz - 1, gz + plane - 1);
  add_bonds(begin, end, 0, nx - 1, smoother, gx + 1, inverse + 1, sink + 1, gx + 2, gy + 1,
            gy + nx + 1, gz + 1, gz + plane + 1);
  add_faces(begin, end, nx - 1, nx, smoother, gx + 1);
  if (y > 0) {
    add_bonds(begin, end, 0, nx, smoother, gy, inverse - nx, sink - nx, gx - (nx + 1), gx - nx,
              gy - nx, gz - nx, gz + plane - nx);
  } else {
    add_faces(begin, end, 0, nx, smoother, gy);
  }
  if (y + 1 < ny) {
    add_bonds(begin, end, 0, nx, smoother, gy + nx, inverse + nx, sink + nx, gx + nx + 1,
              gx + nx + 2, gy + 2 * nx, gz + nx, gz + plane + nx);
  } else {
    add_faces(begin, end, 0, nx, smoother, gy + nx);
  }
  if (z > 0) {
    add_bonds(begin, end, 0, nx, smoother, gz, inverse - plane, sink - plane, gx - plane_x,
              gx - plane_x + 1, gy - plane_y, gy - plane_y + nx, gz - plane);
  } else {
    add_faces(begin, end, 0, nx, smoother, gz);
  }
  if (z + 1 < nz) {
    add_bonds(begin, end, 0, nx, smoother, gz + plane, inverse + plane, sink + plane, gx + plane_x,
              gx + plane_x + 1, gy + plane_y, gy + plane_y + nx, gz + 2 * plane);
  } else {
    add_faces(begin, end, 0, nx, smoother, gz + plane);
  }
  FOR_CELLS(x, 0, nx) {
    smoother[x] = (x + y + z) & 1 ? inverse[x] : omega / smoother[x];
  }
}

// What sweeps read of a cell, side by side (Stencil in grid_stencil_prelude.cl): the conductances of
// its six faces, smoother and sink; of a row, the cells with even x come first. One item per row.
kernel void pack_stencils(const int nx, const int ny, const int nz, global const REAL* restrict gx,
                          global const REAL* restrict gy, global const REAL* restrict gz,
                          global const REAL* restrict sink, global const REAL* restrict smoother,
                          global REAL* restrict stencils) {
  const int pairs = (nx + 1) >> 1;
  FOR_ROW_OF(pairs, ny * nz)
  const int y = row % ny, z = row / ny;
  const size_t first = (size_t)row * nx, plane = (size_t)nx * ny;
  gx += (size_t)row * (nx + 1);
  gy += ((size_t)z * (ny + 1) + y) * nx;
  gz += first;
  for (int parity = 0; parity < 2; ++parity) {
    FOR_CELLS(pair, 0, (nx + 1 - parity) >> 1) {
      const int x = 2 * pair + parity;
      global REAL* to = stencils + 8 * (((size_t)row * 2 + parity) * pairs + pair);
      to[0] = gx[x];
      to[1] = gx[x + 1];
      to[2] = gy[x];
      to[3] = gy[x + nx];
      to[4] = gz[x];
      to[5] = gz[x + plane];
      to[6] = smoother[first + x];
      to[7] = sink[first + x];
    }
  }
}

// Of red cells, their weights of interpolation across one axis (Weights). One item per row.
kernel void pack_weights(const int axis, const int nx, const int ny, const int nz,
                         global const REAL* restrict weight, global REAL* restrict weights) {
  const int pairs = (nx + 1) >> 1;
  FOR_ROW_OF(pairs, ny * nz)
  const int red = (row % ny ^ row / ny) & 1;
  weight += (size_t)row * nx + red;
  weights += 3 * (size_t)row * pairs + axis;
  FOR_CELLS(pair, 0, (nx + 1 - red) >> 1) weights[3 * pair] = weight[2 * pair];
}
