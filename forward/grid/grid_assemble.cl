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

// 1 / D, D = Σ G + S of each cell, and how loosely it holds the node of its coarse cell, D^(−5/8)
// (to_node). One item per row.
kernel void invert_diagonal(const int nx, const int ny, const int nz,
                            global const REAL* restrict gx, global const REAL* restrict gy,
                            global const REAL* restrict gz, global const REAL* restrict sink,
                            global REAL* restrict inverse, global REAL* restrict loose) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  gx += (size_t)row * (nx + 1);
  gy += ((size_t)z * (ny + 1) + y) * nx;
  gz += (size_t)row * nx;
  for (int x = 0; x < nx; ++x) {
    const size_t i = (size_t)row * nx + x;
    const REAL d = gx[x] + gx[x + 1] + gy[x] + gy[x + nx] + gz[x] + gz[x + nx * ny] + sink[i];
    inverse[i] = 1 / d;
    const REAL root = sqrt(inverse[i]);
    loose[i] = root * sqrt(sqrt(root));
  }
}

// Resistance from child `i` to the node of its coarse cell, which lies between it and its sibling
// (across conductance g), nearer to the one held more firmly: the share of 1/g is
// l_i / (l_i + l_sibling) with l = D^(−5/8), one half where κ is even. An only child is the node
// itself. Exponent 1, the node all but on the firmer child, suits κ random per voxel (17 iterations
// at contrast 1e4 on 64³ instead of 20) but ties cubes of three voxels together that are none of
// each other's (more than 100 instead of 17): where both children belong to other clusters, a node
// amid their weak bond lets each follow its own.
REAL to_node(REAL g, REAL loose, REAL loose_sibling) {
  return loose / ((loose + loose_sibling) * g);
}

// Face `before` cell (x, y, z) across `axis`: the one between it and its neighbour below.
#define GRID nx, ny, nz, gx, gy, gz
inline __attribute__((always_inline)) REAL face_at(const int axis, const int x, const int y,
                                                   const int z, const int nx, const int ny,
                                                   const int nz, global const REAL* restrict gx,
                                                   global const REAL* restrict gy,
                                                   global const REAL* restrict gz) {
  const size_t row = (size_t)z * ny + y;
  return axis == 0 ? gx[row * (nx + 1) + x] : axis == 1 ? gy[(row + z) * nx + x] : gz[row * nx + x];
}

// Σ G (w − w_neighbour)² over the bonds of cell (x, y, z) across the two other axes: what the
// coarse difference that w is the share of costs between lines that take unequal shares of it.
inline __attribute__((always_inline)) REAL mismatch(const int axis, const int x, const int y,
                                                    const int z, const int nx, const int ny,
                                                    const int nz, global const REAL* restrict gx,
                                                    global const REAL* restrict gy,
                                                    global const REAL* restrict gz,
                                                    global const REAL* restrict w) {
  const size_t i = ((size_t)z * ny + y) * nx + x;
  const int cell[3] = {x, y, z}, extent[3] = {nx, ny, nz};
  const size_t stride[3] = {1, nx, (size_t)nx * ny};
  REAL sum = 0;
  for (int other = 0; other < 3; ++other) {
    if (other == axis) continue;
    if (cell[other] > 0) {
      const REAL d = w[i] - w[i - stride[other]];
      sum += face_at(other, x, y, z, GRID) * d * d;
    }
    if (cell[other] + 1 < extent[other]) {
      const REAL d = w[i] - w[i + stride[other]];
      sum += face_at(other, x + (other == 0), y + (other == 1), z + (other == 2), GRID) * d * d;
    }
  }
  return sum;
}

// Coarse face conductances across one axis: as near to PᵀAP, P being the interpolation with weights
// w, as one number per face can be. With d the difference of two coarse values, all others being
// equal to theirs, per line of fine cells along the axis
//
//     | s  i | j  s' |     G (1 − w_i − w_j)² d²           between i and j
//                          G w_i (w_i + w_s) d²            between i and its sibling s; so for j
//                          ½ θ Σ G (w_i − w_k)² d²         between i and its neighbours k across
//
// Where the neighbouring face has the same difference the second is exact, whence linear fields in
// an even medium keep their energy. The third is an upper bound, shared with the diagonal couplings
// of PᵀAP that are left out; hence θ. On the surface, series of resistances to the node. An axis
// that is not halved keeps its faces. One item per row of coarse faces.
#define THETA ((REAL)0.3)
kernel void coarsen_faces(const int axis, const int nx, const int ny, const int nz, const int cx,
                          const int cy, const int cz, const int half_x, const int half_y,
                          const int half_z, global const REAL* restrict gx,
                          global const REAL* restrict gy, global const REAL* restrict gz,
                          global const REAL* restrict loose, global const REAL* restrict w,
                          global REAL* restrict coarse) {
  const int across_x = axis == 0, across_y = axis == 1, across_z = axis == 2;
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= (cy + across_y) * (cz + across_z)) return;
  const int coarse_y = row % (cy + across_y), coarse_z = row / (cy + across_y);
  const int halve = axis == 0 ? half_x : axis == 1 ? half_y : half_z;
  const int n = axis == 0 ? nx : axis == 1 ? ny : nz, c = axis == 0 ? cx : axis == 1 ? cy : cz;
  const size_t along = axis == 0 ? 1 : axis == 1 ? (size_t)nx : (size_t)nx * ny;
  // Fine faces in a coarse one; along the axis they lie at one place.
  const int y_begin = min(coarse_y << half_y, ny),
            y_end = across_y ? y_begin + 1 : min((coarse_y + 1) << half_y, ny);
  const int z_begin = min(coarse_z << half_z, nz),
            z_end = across_z ? z_begin + 1 : min((coarse_z + 1) << half_z, nz);
  for (int coarse_x = 0; coarse_x < cx + across_x; ++coarse_x) {
    const int x_begin = min(coarse_x << half_x, nx),
              x_end = across_x ? x_begin + 1 : min((coarse_x + 1) << half_x, nx);
    const int face = axis == 0 ? coarse_x : axis == 1 ? coarse_y : coarse_z;
    const int at = min(face << halve, n);  // between cells at − 1 and at; siblings at − 2, at + 1
    const int surface = face == 0 || face == c;
    const int two_before = halve && face > 0 && 2 * face - 1 < n, two_after = halve && at + 1 < n;
    REAL sum = 0;
    for (int z = z_begin; z < z_end; ++z) {
      for (int y = y_begin; y < y_end; ++y) {
        for (int x = x_begin; x < x_end; ++x) {
          const REAL g = face_at(axis, x, y, z, GRID);
          if (!(g > 0) || !halve) {
            sum += g;
            continue;
          }
          const size_t j = ((size_t)z * ny + y) * nx + x, i = j - along;
          const REAL bond_i =
              two_before ? face_at(axis, x - across_x, y - across_y, z - across_z, GRID) : (REAL)0;
          const REAL bond_j =
              two_after ? face_at(axis, x + across_x, y + across_y, z + across_z, GRID) : (REAL)0;
          if (surface) {
            REAL resistance = 1 / g;
            if (two_before) resistance += to_node(bond_i, loose[i], loose[i - along]);
            if (two_after) resistance += to_node(bond_j, loose[j], loose[j + along]);
            sum += 1 / resistance;
            continue;
          }
          const REAL drop = 1 - w[i] - w[j];
          sum += g * drop * drop;
          // A sibling's own share counts where there is a coarse cell to share with.
          if (two_before) sum += bond_i * w[i] * (w[i] + (face > 1 ? w[i - along] : (REAL)0));
          if (two_after) sum += bond_j * w[j] * (w[j] + (face + 1 < c ? w[j + along] : (REAL)0));
          sum += THETA / 2 *
                 (mismatch(axis, x - across_x, y - across_y, z - across_z, GRID, w) +
                  mismatch(axis, x, y, z, GRID, w));
        }
      }
    }
    coarse[(size_t)row * (cx + across_x) + coarse_x] = sum;
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

// Interpolation weights across one axis (grid_transfer.cl) for every fine cell; 0 where the axis is
// not halved. One item per row.
kernel void weights(const int axis, const int halve, const int nx, const int ny, const int nz,
                    global const REAL* restrict gx, global const REAL* restrict gy,
                    global const REAL* restrict gz, global const REAL* restrict loose,
                    global REAL* restrict weight) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  const int across_x = axis == 0, across_y = axis == 1, across_z = axis == 2;
  const int n = axis == 0 ? nx : axis == 1 ? ny : nz;
  const int along = axis == 0 ? 1 : axis == 1 ? nx : nx * ny;
  for (int x = 0; x < nx; ++x) {
    const size_t cell = (size_t)row * nx + x;
    if (!halve) {
      weight[cell] = 0;
      continue;
    }
    // An odd cell has its sibling before it and the coarse neighbour's child j after it; an even
    // one the other way round: `away` leads from the sibling to j.
    const int i = axis == 0 ? x : axis == 1 ? y : z;
    const int odd = i & 1, away = 2 * odd - 1;
    const int has_sibling = i - away < n, has_j_sibling = i + 2 * away >= 0 && i + 2 * away < n;
    // Faces on the side of j, of the sibling, and between j and its sibling.
#define FACE(k) face_at(axis, x + (k)*across_x, y + (k)*across_y, z + (k)*across_z, GRID)
    const REAL g = FACE(odd);
    REAL here = 0, there = 0;
    if (has_sibling) here = to_node(FACE(1 - odd), loose[cell], loose[cell - away * along]);
    if (has_j_sibling) {
      there =
          to_node(FACE(3 * odd - 1), loose[cell + away * along], loose[cell + 2 * away * along]);
    }
#undef FACE
    weight[cell] = g > 0 ? here / (here + 1 / g + there) : (REAL)0;
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
