// Conductances of the finest level from κ and μ, of each coarser level from the finer one, and the
// weights of interpolation between them. All arrays are scalar, layouts as in grid_operator.cl.

// Boundary faces: G_b = h² / (h/(2κ) + 2A); 0 on mirrors.
REAL robin(REAL kappa, REAL h, REAL two_a, int open) {
  return open ? h * h / (h / (2 * kappa) + two_a) : (REAL)0;
}
REAL harmonic(REAL a, REAL b, REAL h) {
  return h * 2 * (a * b / (a + b));
}

// One item per row (y, z). open_x, open_y, open_z: whether the faces across that axis are open.
kernel void assemble(const int nx, const int ny, const int nz, const REAL h, const REAL two_a,
                     const int open_x, const int open_y, const int open_z,
                     global const REAL* restrict kappa, global const REAL* restrict mu,
                     global REAL* restrict gx, global REAL* restrict gy, global REAL* restrict gz,
                     global REAL* restrict sink) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  const size_t first = (size_t)row * nx;
  const size_t plane = (size_t)nx * ny;
  global REAL* face_x = gx + (size_t)row * (nx + 1);
  global REAL* face_y = gy + ((size_t)z * (ny + 1) + y) * nx;
  for (int x = 0; x < nx; ++x) {
    const size_t i = first + x;
    const REAL k = kappa[i];
    sink[i] = mu[i] * h * h * h;
    face_x[x] = x > 0 ? harmonic(kappa[i - 1], k, h) : robin(k, h, two_a, open_x);
    face_y[x] = y > 0 ? harmonic(kappa[i - nx], k, h) : robin(k, h, two_a, open_y);
    gz[i] = z > 0 ? harmonic(kappa[i - plane], k, h) : robin(k, h, two_a, open_z);
    if (x == nx - 1) face_x[nx] = robin(k, h, two_a, open_x);
    if (y == ny - 1) face_y[x + nx] = robin(k, h, two_a, open_y);
    if (z == nz - 1) gz[i + plane] = robin(k, h, two_a, open_z);
  }
}

// 1 / D, D = Σ G + S of each cell. One item per row.
kernel void invert_diagonal(const int nx, const int ny, const int nz,
                            global const REAL* restrict gx, global const REAL* restrict gy,
                            global const REAL* restrict gz, global const REAL* restrict sink,
                            global REAL* restrict inverse) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  gx += (size_t)row * (nx + 1);
  gy += ((size_t)z * (ny + 1) + y) * nx;
  gz += (size_t)row * nx;
  for (int x = 0; x < nx; ++x) {
    const size_t i = (size_t)row * nx + x;
    inverse[i] = 1 / (gx[x] + gx[x + 1] + gy[x] + gy[x + nx] + gz[x] + gz[x + nx * ny] + sink[i]);
  }
}

// Resistance from child `i` to the node of its coarse cell, which lies between it and its sibling
// (across conductance g), nearer to the one held more firmly: the share of 1/g is
// (1/D_i) / (1/D_i + 1/D_sibling), one half where κ is even. An only child is the node itself.
REAL to_node(REAL g, REAL inverse, REAL inverse_sibling) {
  return inverse / ((inverse + inverse_sibling) * g);
}

// Coarse face conductances across one axis: per fine face a series of resistances from node to
// node, the fine faces of a coarse one in parallel. The axis has n fine and c coarse cells, `step`
// being the stride of faces along it; the two other axes p and q likewise; `cell...` are strides of
// cells. `halve...` is 1 for an axis that is halved and 0 for one that is not, whose faces
// then stay what they are. One item per coarse (P, Q); faces 0..c along the axis.
kernel void coarsen_faces(const int n, const int c, const int np, const int nq, const int cp,
                          const int cq, const int halve, const int halve_p, const int halve_q,
                          const int step, const int step_p, const int step_q, const int cell,
                          const int cell_p, const int cell_q, const int coarse_step,
                          const int coarse_step_p, const int coarse_step_q,
                          global const REAL* restrict inverse, global const REAL* restrict fine,
                          global REAL* restrict coarse) {
  const int item = (int)get_global_id(1);
  if (get_global_id(0) > 0 || item >= cp * cq) return;
  const int coarse_p = item % cp, coarse_q = item / cp;
  const int p_begin = coarse_p << halve_p, p_end = min((coarse_p + 1) << halve_p, np);
  const int q_begin = coarse_q << halve_q, q_end = min((coarse_q + 1) << halve_q, nq);
  for (int face = 0; face <= c; ++face) {
    // Face f lies between cells f−1 and f; their siblings are f−2 and f+1.
    const int f = min(face << halve, n);
    const int two_before = halve && face > 0 && 2 * face - 1 < n;
    const int two_after = halve && 2 * face + 1 < n;
    REAL sum = 0;
    for (int q = q_begin; q < q_end; ++q) {
      for (int p = p_begin; p < p_end; ++p) {
        const int at = p * step_p + q * step_q + f * step;
        const int after = p * cell_p + q * cell_q + f * cell, before = after - cell;
        const REAL g = fine[at];
        REAL resistance = 1 / g;
        if (two_before) {
          resistance += to_node(fine[at - step], inverse[before], inverse[before - cell]);
        }
        if (two_after) {
          resistance += to_node(fine[at + step], inverse[after], inverse[after + cell]);
        }
        if (g > 0) sum += 1 / resistance;
      }
    }
    coarse[face * coarse_step + coarse_p * coarse_step_p + coarse_q * coarse_step_q] = sum;
  }
}

// Coarse S = sum over the children. One item per coarse row.
kernel void coarsen_sink(const int nx, const int ny, const int nz, const int cx, const int cy,
                         const int cz, const int half_x, const int half_y, const int half_z,
                         global const REAL* restrict fine, global REAL* restrict coarse) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= cy * cz) return;
  const int cell_y = row % cy, cell_z = row / cy;
  for (int cell_x = 0; cell_x < cx; ++cell_x) {
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

// Interpolation weights across one axis (grid_transfer.cl) for every fine cell; arguments as in
// coarsen_faces. One item per fine (p, q).
kernel void weights(const int n, const int np, const int nq, const int halve, const int step,
                    const int step_p, const int step_q, const int cell, const int cell_p,
                    const int cell_q, global const REAL* restrict inverse,
                    global const REAL* restrict fine, global REAL* restrict weight) {
  const int item = (int)get_global_id(1);
  if (get_global_id(0) > 0 || item >= np * nq) return;
  const int p = item % np, q = item / np;
  const int faces = p * step_p + q * step_q, cells = p * cell_p + q * cell_q;
  for (int i = 0; i < n; ++i) {
    if (!halve) {
      weight[cells + i * cell] = 0;
      continue;
    }
    // An odd cell has its sibling before it and the coarse neighbour's child j after it; an even
    // one the other way round. Face k lies before cell k.
    const int odd = i & 1;
    const int sibling = odd ? i - 1 : i + 1, j = odd ? i + 1 : i - 1,
              j_sibling = odd ? i + 2 : i - 2;
    const int has_sibling = sibling < n, has_j_sibling = j_sibling >= 0 && j_sibling < n;
    const REAL g = fine[faces + max(i, j) * step];
    REAL here = 0, there = 0;
    if (has_sibling) {
      here = to_node(fine[faces + max(i, sibling) * step], inverse[cells + i * cell],
                     inverse[cells + sibling * cell]);
    }
    if (has_j_sibling) {
      there = to_node(fine[faces + max(j, j_sibling) * step], inverse[cells + j * cell],
                      inverse[cells + j_sibling * cell]);
    }
    weight[cells + i * cell] = g > 0 ? here / (here + 1 / g + there) : (REAL)0;
  }
}

// Σ (G₋ + G₊) / D over the cells of a row, for each axis: where a cell's flux can go. One item per
// row; shares [row][3].
kernel void axis_shares(const int nx, const int ny, const int nz, global const REAL* restrict gx,
                        global const REAL* restrict gy, global const REAL* restrict gz,
                        global const REAL* restrict inverse, global ACCU* restrict shares) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  gx += (size_t)row * (nx + 1);
  gy += ((size_t)z * (ny + 1) + y) * nx;
  gz += (size_t)row * nx;
  inverse += (size_t)row * nx;
  ACCU along_x = 0, along_y = 0, along_z = 0;
  for (int x = 0; x < nx; ++x) {
    along_x += (gx[x] + gx[x + 1]) * inverse[x];
    along_y += (gy[x] + gy[x + nx]) * inverse[x];
    along_z += (gz[x] + gz[x + nx * ny]) * inverse[x];
  }
  shares[3 * row] = along_x;
  shares[3 * row + 1] = along_y;
  shares[3 * row + 2] = along_z;
}

// What relaxes a level (grid_stream_prelude.cl): 1 / D on black cells, ω / S_ii on red ones, with
// S_ii = S
// + Σ G (1 − G / D_neighbour) the diagonal of the reduced system. D_neighbour − G is summed from
// the neighbour's other parts, since it may be far smaller than both. With ω = 5/6 the sweep is
// Gauss-Seidel's in a uniform medium; below 1 the cycle is sure to be positive definite, because
// the eigenvalues of S scaled by its diagonal lie in (0, 2]. One item per row.
kernel void make_smoother(const int nx, const int ny, const int nz, const REAL omega,
                          global const REAL* restrict gx, global const REAL* restrict gy,
                          global const REAL* restrict gz, global const REAL* restrict sink,
                          global const REAL* restrict inverse, global REAL* restrict smoother) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  const size_t plane = (size_t)nx * ny;
  for (int x = 0; x < nx; ++x) {
    const size_t i = (size_t)row * nx + x;
    if ((x + y + z) & 1) {
      smoother[i] = inverse[i];
      continue;
    }
    REAL diagonal = sink[i];
    for (int face = 0; face < 6; ++face) {
      const int axis = face >> 1, up = face & 1;
      const int u = x + (axis == 0) * (2 * up - 1), v = y + (axis == 1) * (2 * up - 1),
                w = z + (axis == 2) * (2 * up - 1);
      const size_t neighbour_row = (size_t)w * ny + v;
      const REAL g = axis == 0   ? gx[(size_t)row * (nx + 1) + x + up]
                     : axis == 1 ? gy[((size_t)z * (ny + 1) + y + up) * nx + x]
                                 : gz[i + up * plane];
      if (u < 0 || u >= nx || v < 0 || v >= ny || w < 0 || w >= nz) {
        diagonal += g;
        continue;
      }
      const size_t j = neighbour_row * nx + u;
      REAL others = sink[j];
      for (int other = 0; other < 6; ++other) {
        if (other == (face ^ 1)) continue;
        const int far = other & 1;
        others += other < 2   ? gx[neighbour_row * (nx + 1) + u + far]
                  : other < 4 ? gy[((size_t)w * (ny + 1) + v + far) * nx + u]
                              : gz[j + far * plane];
      }
      diagonal += g * (others * inverse[j]);
    }
    smoother[i] = omega / diagonal;
  }
}
