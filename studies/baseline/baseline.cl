// Relaxation and diagonally preconditioned conjugate gradients on a batch of fields, on one grid:
//
//   (A φ)_i = Σ_faces G (φ_i − φ_neighbour) + S_i φ_i,     φ_neighbour = 0 outside the block
//
// in flux form: differences first, so that float keeps the small S = μ h³. `inverse` is 1/(ΣG + S).
//
// Layout. A field is [z][y][x][GROUPS] vectors of WIDTH patterns. Face conductances include the
// boundary faces (0 on mirrors): gx is [nz][ny][nx+1], gy [nz][ny+1][nx], gz [nz+1][ny][nx]; gx[x]
// lies between cells x−1 and x. Scalars and sums are [run][GROUPS] vectors.
//
// Active cells (Fig. 8 of [W]): fewer than `depth` cells from an open face; all others keep their
// values and are left out of residuals. open_x tells whether the two x faces are open, and so on.
// With a depth beyond every extent all cells are active.
//
// Work. Sweeps: global id 0 = group + GROUPS segment of SEGMENT cells of a row, 1 = row = y + ny z.
// Sums: global id 0 = group + GROUPS run; a run is a stretch of cells, or, INTERLEAVED, every
// runs-th cell, so that neighbouring items touch neighbouring memory. Number types and names begin
// with grid/grid_prelude.cl.
#ifndef INTERLEAVED
#define INTERLEAVED 0
#endif
#define GRID_ARGUMENTS                                                      \
  const int nx, const int ny, const int nz, global const REAL *restrict gx, \
      global const REAL *restrict gy, global const REAL *restrict gz,       \
      global const REAL *restrict sink
#define DEPTH_ARGUMENTS const int depth, const int open_x, const int open_y, const int open_z

// (A φ) at cell i = x + nx row, row = y + ny z, with φ of type T in `field` and `to` converting to
// T.
#define OPERATOR(T, to, field)                                                          \
  (gx[i + row] * (here - (x > 0 ? to(field[f - GROUPS]) : (T)(0))) +                    \
   gx[i + row + 1] * (here - (x + 1 < nx ? to(field[f + GROUPS]) : (T)(0))) +           \
   gy[i + nx * z] * (here - (y > 0 ? to(field[f - GROUPS * nx]) : (T)(0))) +            \
   gy[i + nx * (z + 1)] * (here - (y + 1 < ny ? to(field[f + GROUPS * nx]) : (T)(0))) + \
   gz[i] * (here - (z > 0 ? to(field[f - GROUPS * nx * ny]) : (T)(0))) +                \
   gz[i + nx * ny] * (here - (z + 1 < nz ? to(field[f + GROUPS * nx * ny]) : (T)(0))) + \
   sink[i] * here)

int is_inner(const int open, const int at, const int extent, const int depth) {
  return !open || min(at, extent - 1 - at) >= depth;
}

// Which cells a sweep's item walks.
#define SWEEP_SETUP                                                                           \
  const int group = (int)get_global_id(0) % GROUPS, segment = (int)get_global_id(0) / GROUPS; \
  const int row = (int)get_global_id(1);                                                      \
  const int x_begin = segment * SEGMENT;                                                      \
  if (row >= ny * nz || x_begin >= nx) return;                                                \
  const int x_end = SEGMENT < nx - x_begin ? x_begin + SEGMENT : nx;                          \
  const int y = row % ny, z = row / ny;                                                       \
  const int inner = is_inner(open_y, y, ny, depth) && is_inner(open_z, z, nz, depth);

// [W] 5.2's update, the new value of a cell from its neighbours' old ones, written as an increment:
// out = in + (rhs − A in) / (ΣG + S).
kernel void jacobi(GRID_ARGUMENTS, global const REAL* restrict inverse, DEPTH_ARGUMENTS,
                   global const vec* restrict rhs, global const vec* restrict in,
                   global vec* restrict out) {
  SWEEP_SETUP
  for (int x = x_begin; x < x_end; ++x) {
    if (inner && is_inner(open_x, x, nx, depth)) continue;
    const int i = x + nx * row;
    const size_t f = (size_t)i * GROUPS + group;
    const vec here = in[f];
    out[f] = here + inverse[i] * (rhs[f] - OPERATOR(vec, to_vec, in));
  }
}

// Half a Gauss-Seidel sweep in place, on cells of `colour` = (x + y + z) mod 2, whose neighbours
// all have the other colour.
kernel void gauss_seidel(GRID_ARGUMENTS, global const REAL* restrict inverse, DEPTH_ARGUMENTS,
                         const int colour, global const vec* restrict rhs,
                         global vec* restrict phi) {
  SWEEP_SETUP
  for (int x = x_begin + ((colour ^ x_begin ^ y ^ z) & 1); x < x_end; x += 2) {
    if (inner && is_inner(open_x, x, nx, depth)) continue;
    const int i = x + nx * row;
    const size_t f = (size_t)i * GROUPS + group;
    const vec here = phi[f];
    phi[f] = here + inverse[i] * (rhs[f] - OPERATOR(vec, to_vec, phi));
  }
}

// Walks the cells of this item's run.
#define FOR_CELLS_OF_RUN(cells, runs)                                                     \
  const int group = (int)get_global_id(0) % GROUPS, run = (int)get_global_id(0) / GROUPS; \
  if (run >= runs) return;                                                                \
  const int length = (cells - 1) / runs + 1;                                              \
  const int first_ = INTERLEAVED ? run : run * length, step_ = INTERLEAVED ? runs : 1;    \
  const int end_ = INTERLEAVED ? cells : min(cells, first_ + length);                     \
  for (int i = first_; i < end_; i += step_)

// Σ (rhs − A φ)² over the active cells of each run, in ACCU.
kernel void residual_norm(GRID_ARGUMENTS, DEPTH_ARGUMENTS, const int runs,
                          global const vec* restrict rhs, global const vec* restrict phi,
                          global accu_vec* restrict partial) {
  accu_vec sum = (accu_vec)(0);
  FOR_CELLS_OF_RUN(nx * ny * nz, runs) {
    const int row = i / nx, x = i - nx * row, z = row / ny, y = row - ny * z;
    if (is_inner(open_x, x, nx, depth) && is_inner(open_y, y, ny, depth) &&
        is_inner(open_z, z, nz, depth)) {
      continue;
    }
    const size_t f = (size_t)i * GROUPS + group;
    const accu_vec here = to_accu(phi[f]);
    const accu_vec difference = to_accu(rhs[f]) - OPERATOR(accu_vec, to_accu, phi);
    sum += difference * difference;
  }
  partial[run * GROUPS + group] = sum;
}

// Σ ((ΣG + S) φ)² over the active cells of each run, in ACCU: times half a unit in the last place,
// what of a residual rounding φ can hide.
kernel void diagonal_norm(const int nx, const int ny, const int nz,
                          global const REAL* restrict inverse, DEPTH_ARGUMENTS, const int runs,
                          global const vec* restrict phi, global accu_vec* restrict partial) {
  accu_vec sum = (accu_vec)(0);
  FOR_CELLS_OF_RUN(nx * ny * nz, runs) {
    const int row = i / nx, x = i - nx * row, z = row / ny, y = row - ny * z;
    if (is_inner(open_x, x, nx, depth) && is_inner(open_y, y, ny, depth) &&
        is_inner(open_z, z, nz, depth)) {
      continue;
    }
    const accu_vec value = to_accu(phi[(size_t)i * GROUPS + group]) / (ACCU)inverse[i];
    sum += value * value;
  }
  partial[run * GROUPS + group] = sum;
}

// The parent's light is its children's, [W] 5.3's coarse problem; under the boundary source, where
// the light is G_b q, `scale` of each parent keeps q instead. One item per group and parent.
kernel void sum_children(const int nx, const int ny, const int nz,
                         global const REAL* restrict scale, global const vec* restrict fine,
                         global vec* restrict coarse) {
  const int group = (int)get_global_id(0) % GROUPS, parent = (int)get_global_id(0) / GROUPS;
  const int cx = (nx + 1) / 2, cy = (ny + 1) / 2, cz = (nz + 1) / 2;
  if (parent >= cx * cy * cz) return;
  const int px = parent % cx, py = parent / cx % cy, pz = parent / cx / cy;
  vec sum = (vec)(0);
  for (int z = 2 * pz; z < min(nz, 2 * pz + 2); ++z) {
    for (int y = 2 * py; y < min(ny, 2 * py + 2); ++y) {
      for (int x = 2 * px; x < min(nx, 2 * px + 2); ++x) {
        sum += fine[(size_t)(x + nx * (y + ny * z)) * GROUPS + group];
      }
    }
  }
  coarse[(size_t)parent * GROUPS + group] = scale[parent] * sum;
}

// [W] 5.3: each child starts from its parent's value. One item per group and child.
kernel void copy_to_children(const int nx, const int ny, const int nz,
                             global const vec* restrict coarse, global vec* restrict fine) {
  const int group = (int)get_global_id(0) % GROUPS, child = (int)get_global_id(0) / GROUPS;
  if (child >= nx * ny * nz) return;
  const int cx = (nx + 1) / 2, cy = (ny + 1) / 2;
  const int parent = child % nx / 2 + cx * (child / nx % ny / 2 + cy * (child / nx / ny / 2));
  fine[(size_t)child * GROUPS + group] = coarse[(size_t)parent * GROUPS + group];
}

// Conjugate gradients: the solution is kept in ACCU, so that its storage does not bound the
// attainable residual. r = rhs − A x; per run Σ r² and Σ r²/(ΣG + S).
kernel void cg_residual(GRID_ARGUMENTS, global const REAL* restrict inverse, const int runs,
                        global const vec* restrict rhs, global const accu_vec* restrict solution,
                        global vec* restrict r, global accu_vec* restrict rr,
                        global accu_vec* restrict rz) {
  accu_vec sum = (accu_vec)(0), weighted = (accu_vec)(0);
  FOR_CELLS_OF_RUN(nx * ny * nz, runs) {
    const int row = i / nx, x = i - nx * row, z = row / ny, y = row - ny * z;
    const size_t f = (size_t)i * GROUPS + group;
    const accu_vec here = solution[f];
    const accu_vec difference = to_accu(rhs[f]) - OPERATOR(accu_vec, (accu_vec), solution);
    r[f] = to_vec(difference);
    sum += difference * difference;
    weighted += difference * difference * (ACCU)inverse[i];
  }
  rr[run * GROUPS + group] = sum;
  rz[run * GROUPS + group] = weighted;
}

// p = r/(ΣG + S) + β p
kernel void cg_direction(const int cells, const int runs, global const REAL* restrict inverse,
                         global const accu_vec* restrict beta, global const vec* restrict r,
                         global vec* restrict p) {
  FOR_CELLS_OF_RUN(cells, runs) {
    const size_t f = (size_t)i * GROUPS + group;
    p[f] = inverse[i] * r[f] + to_vec(beta[group]) * p[f];
  }
}

// q = A p and per run Σ p·q
kernel void cg_apply(GRID_ARGUMENTS, const int runs, global const vec* restrict p,
                     global vec* restrict q, global accu_vec* restrict pq) {
  accu_vec sum = (accu_vec)(0);
  FOR_CELLS_OF_RUN(nx * ny * nz, runs) {
    const int row = i / nx, x = i - nx * row, z = row / ny, y = row - ny * z;
    const size_t f = (size_t)i * GROUPS + group;
    const vec here = p[f];
    const vec value = OPERATOR(vec, to_vec, p);
    q[f] = value;
    sum += to_accu(value) * to_accu(here);
  }
  pq[run * GROUPS + group] = sum;
}

// x += α p, r −= α q; per run Σ r² and Σ r²/(ΣG + S).
kernel void cg_step(const int cells, const int runs, global const REAL* restrict inverse,
                    global const accu_vec* restrict alpha, global const vec* restrict p,
                    global const vec* restrict q, global accu_vec* restrict solution,
                    global vec* restrict r, global accu_vec* restrict rr,
                    global accu_vec* restrict rz) {
  accu_vec sum = (accu_vec)(0), weighted = (accu_vec)(0);
  FOR_CELLS_OF_RUN(cells, runs) {
    const size_t f = (size_t)i * GROUPS + group;
    solution[f] += alpha[group] * to_accu(p[f]);
    const vec next = r[f] - to_vec(alpha[group]) * q[f];
    r[f] = next;
    const accu_vec square = to_accu(next) * to_accu(next);
    sum += square;
    weighted += square * (ACCU)inverse[i];
  }
  rr[run * GROUPS + group] = sum;
  rz[run * GROUPS + group] = weighted;
}
