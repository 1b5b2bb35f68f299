// From a level to the next coarser one across an axis that is halved: weights of interpolation and
// coarse face conductances. Rows of x are worked on whole, without branches inside; hence kernels
// in pairs, one for pairs of cells in a row (axis x), one for pairs of rows (axes y and z). On GPUs
// an item has one cell or coarse face of its row. Arrays are scalar, layouts as in
// grid_operator.cl.
//
// Across a halved axis of n cells, c = (n + 1) / 2 coarse ones, coarse face f lies between the fine
// cells i and j, whose siblings are s and s':
//
//     | s   i | j   s' |         i = at − 1, j = at, s = at − 2, s' = at + 1, at = min(2 f, n)
//
// f = 0 has no i, f = c no j; the last cell of an odd n is an only child.

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

// Interpolation weight (grid_stencil_prelude.cl) of a cell `here` away from its own node: its part
// of the way to the other node, which lies `there` beyond face g.
REAL weight_of(REAL g, REAL here, REAL there) {
  return g > 0 ? here / (here + 1 / g + there) : (REAL)0;
}

// Weights across x. One item per row.
kernel void weights_in_rows(const int nx, const int ny, const int nz,
                            global const REAL* restrict gx, global const REAL* restrict loose,
                            global REAL* restrict weight) {
  FOR_SCALAR_ROW
  gx += (size_t)row * (nx + 1);
  loose += (size_t)row * nx;
  weight += (size_t)row * nx;
  FOR_CELLS(f, 1, nx / 2) {
    const int j = 2 * f;
    const REAL here = to_node(gx[j - 1], loose[j - 1], loose[j - 2]);
    const REAL there = to_node(gx[j + 1], loose[j], loose[j + 1]);
    weight[j - 1] = weight_of(gx[j], here, there);
    weight[j] = weight_of(gx[j], there, here);
  }
  if (begin > 0) return;
  weight[0] = nx > 1 ? weight_of(gx[0], to_node(gx[1], loose[0], loose[1]), 0) : (REAL)0;
  if (nx > 1) {
    const int i =
        nx - 1 - (nx & 1);  // the last odd cell: a face of the block or an only child next
    weight[i] = weight_of(gx[i + 1], to_node(gx[i], loose[i], loose[i - 1]), 0);
    if (i + 1 < nx) weight[i + 1] = 0;
  }
}

// to_node of the child at `loose` with its sibling, if any, `sibling` cells away.
inline __attribute__((always_inline)) REAL child_to_node(const int has_sibling,
                                                         global const REAL* bond,
                                                         global const REAL* loose,
                                                         const long sibling) {
  return has_sibling ? to_node(*bond, *loose, loose[sibling]) : (REAL)0;
}

// Weights across axis 1 (y) or 2 (z), whose faces are g. One item per coarse face and row: writes i
// and j.
kernel void weights_between_rows(const int axis, const int nx, const int ny, const int nz,
                                 global const REAL* restrict g, global const REAL* restrict loose,
                                 global REAL* restrict weight) {
  const int n = axis == 1 ? ny : nz, c = (n + 1) / 2;
  FOR_ROW_OF(nx, (c + 1) * (axis == 1 ? nz : ny))
  const int f = axis == 1 ? row % (c + 1) : row / ny, at = min(2 * f, n);
  const int other = axis == 1 ? row / (c + 1) : row % ny;
  const long along = axis == 1 ? nx : (long)nx * ny;  // between rows of cells or faces
  const long j = at * along + other * (axis == 1 ? (long)nx * ny : nx);
  g += j + (axis == 1 ? (long)other * nx : 0);
  loose += j;
  weight += j;
  const int i_has_sibling = f > 0 && at == 2 * f, j_has_sibling = at + 1 < n;
  // Two loops, each with one row to write.
  FOR_CELLS(x, 0, f > 0 ? nx : 0) {
    const REAL here = child_to_node(i_has_sibling, g + x - along, loose + x - along, -along);
    const REAL there = child_to_node(j_has_sibling, g + x + along, loose + x, along);
    weight[x - along] = weight_of(g[x], here, there);
  }
  FOR_CELLS(x, 0, at < n ? nx : 0) {
    const REAL here = child_to_node(j_has_sibling, g + x + along, loose + x, along);
    const REAL there = child_to_node(i_has_sibling, g + x - along, loose + x - along, -along);
    weight[x] = weight_of(g[x], here, there);
  }
}

// Coarse face conductances across one axis: as near to PᵀAP, P being the interpolation with weights
// w, as one number per face can be. With d the difference of two coarse values, all others being
// equal to theirs, per line of fine cells along the axis
//
//     G (1 − w_i − w_j)² d²           between i and j
//     G w_i (w_i + w_s) d²            between i and its sibling s; so for j
//     ½ θ Σ G (w_i − w_k)² d²         between i and its neighbours k across
//
// Where the neighbouring face has the same difference the second is exact, whence linear fields in
// an even medium keep their energy. The third is an upper bound, shared with the diagonal couplings
// of PᵀAP that are left out; hence θ. A sibling's own share w_s counts where there is a coarse cell
// to share with, not on the surface. There, series of resistances to the node.
#define THETA ((REAL)0.3)
#define BLOCK (SEGMENT == 1 ? 2 : 128)  // cells of a row whose energies an item holds at a time

REAL step_energy(REAL g, REAL w_i, REAL w_j) {
  const REAL drop = 1 - w_i - w_j;
  return g * drop * drop;
}
REAL sibling_energy(REAL bond, REAL w, REAL w_sibling) {
  return bond * w * (w + w_sibling);
}
REAL surface_conductance(REAL g, REAL bond, REAL loose, REAL loose_sibling) {
  return g > 0 ? 1 / (1 / g + to_node(bond, loose, loose_sibling)) : (REAL)0;
}

// The third term for cells x_begin <= x < x_end of a row and their neighbours k across faces g.
inline __attribute__((always_inline)) void add_mismatch(const int x_begin, const int x_end,
                                                        REAL* energy, global const REAL* restrict g,
                                                        global const REAL* restrict w,
                                                        global const REAL* restrict w_k) {
  for (int x = x_begin; x < x_end; ++x) {
    const REAL d = w[x] - w_k[x];
    energy[x - x_begin] += THETA / 2 * g[x] * d * d;
  }
}

// Across x. One item per coarse row or face.
kernel void coarsen_faces_in_rows(const int nx, const int ny, const int nz, const int half_y,
                                  const int half_z, global const REAL* restrict gx,
                                  global const REAL* restrict gy, global const REAL* restrict gz,
                                  global const REAL* restrict loose, global const REAL* restrict w,
                                  global REAL* restrict coarse) {
  const int c = (nx + 1) / 2, cy = (ny + half_y) >> half_y, cz = (nz + half_z) >> half_z;
  FOR_ROW_OF(c + 1, cy * cz)
  coarse += (size_t)row * (c + 1);
  const int y_begin = row % cy << half_y, y_end = min(y_begin + 1 + half_y, ny);
  const int z_begin = row / cy << half_z, z_end = min(z_begin + 1 + half_z, nz);
  const size_t plane = (size_t)nx * ny;
  if (begin == 0 || end == c + 1) {
    REAL first_face = 0, last_face = 0;
    for (int z = z_begin; z < z_end; ++z) {
      for (int y = y_begin; y < y_end; ++y) {
        const size_t fine = (size_t)z * ny + y;
        global const REAL* g = gx + fine * (nx + 1);
        global const REAL* l = loose + fine * nx;
        first_face += nx > 1 ? surface_conductance(g[0], g[1], l[0], l[1]) : g[0];
        last_face += nx & 1 ? g[nx] : surface_conductance(g[nx], g[nx - 1], l[nx - 1], l[nx - 2]);
      }
    }
    if (begin == 0) coarse[0] = first_face;
    if (end == c + 1) coarse[c] = last_face;
  }
  for (int from = max(begin, 1); from < min(end, c); from += BLOCK / 2) {
    // Inner faces from to to − 1, between cells 2 from − 1 to 2 to − 2.
    const int to = min(from + BLOCK / 2, min(end, c)), x_begin = 2 * from - 1, x_end = 2 * to - 1;
    REAL mismatch[BLOCK], line[BLOCK / 2];
    for (int k = 0; k < 2 * (to - from); ++k) mismatch[k] = 0;
    for (int k = 0; k < to - from; ++k) line[k] = 0;
    for (int z = z_begin; z < z_end; ++z) {
      for (int y = y_begin; y < y_end; ++y) {
        const size_t fine = (size_t)z * ny + y;
        global const REAL* g = gx + fine * (nx + 1);
        global const REAL* v = w + fine * nx;
        global const REAL* south = gy + (fine + z) * nx;
        global const REAL* down = gz + fine * nx;
        if (y > 0) add_mismatch(x_begin, x_end, mismatch, south, v, v - nx);
        if (y + 1 < ny) add_mismatch(x_begin, x_end, mismatch, south + nx, v, v + nx);
        if (z > 0) add_mismatch(x_begin, x_end, mismatch, down, v, v - plane);
        if (z + 1 < nz) add_mismatch(x_begin, x_end, mismatch, down + plane, v, v + plane);
        for (int f = from; f < to; ++f) {
          const int j = 2 * f, i = j - 1;
          line[f - from] += step_energy(g[j], v[i], v[j]) +
                            sibling_energy(g[i], v[i], f > 1 ? v[i - 1] : (REAL)0) +
                            sibling_energy(g[j + 1], v[j], f + 1 < c ? v[j + 1] : (REAL)0);
        }
      }
    }
    for (int f = from; f < to; ++f) {
      const int k = f - from;
      coarse[f] = line[k] + mismatch[2 * k] + mismatch[2 * k + 1];
    }
  }
}

// Across axis 1 (y) or 2 (z), whose faces are g; g_other are those across the other of the two.
// One item per row of coarse faces.
kernel void coarsen_faces_between_rows(
    const int axis, const int nx, const int ny, const int nz, const int half_x,
    const int half_other, global const REAL* restrict gx, global const REAL* restrict g,
    global const REAL* restrict g_other, global const REAL* restrict loose,
    global const REAL* restrict w, global REAL* restrict coarse) {
  const int n = axis == 1 ? ny : nz, c = (n + 1) / 2;
  const int others = axis == 1 ? nz : ny, coarse_others = (others + half_other) >> half_other;
  const int cx = (nx + half_x) >> half_x;
  FOR_ROW_OF(cx, (c + 1) * coarse_others)
  coarse += (size_t)row * cx;
  const int f = axis == 1 ? row % (c + 1) : row / coarse_others, at = min(2 * f, n);
  const int first = (axis == 1 ? row / (c + 1) : row % coarse_others) << half_other;
  const int last = min(first + half_other, others - 1);
  const long along = axis == 1 ? nx : (long)nx * ny;  // between rows of cells or faces
  const long across = axis == 1 ? (long)nx * ny : nx;
  const int inner = f > 0 && f < c, has_sibling = f == 0 ? n > 1 : at == 2 * f;
  const int stop = min(end << half_x, nx);
  for (int x_begin = begin << half_x; x_begin < stop; x_begin += BLOCK) {
    const int x_end = min(x_begin + BLOCK, stop);
    REAL energy[BLOCK];
    for (int k = 0; k < BLOCK; ++k) energy[k] = 0;
    for (int other = first; other <= last; ++other) {
      const long j = at * along + other * across, i = j - along;
      global const REAL* face = g + j + (axis == 1 ? (long)other * nx : 0);
      if (!inner) {
        // The cell within, from it to its sibling, and the bond between them.
        const long cell = f == 0 ? j : i, inwards = f == 0 ? along : -along;
        for (int x = x_begin; x < x_end; ++x) {
          energy[x - x_begin] +=
              has_sibling ? surface_conductance(face[x], face[x + inwards], loose[cell + x],
                                                loose[cell + inwards + x])
                          : face[x];
        }
        continue;
      }
      for (int x = x_begin; x < x_end; ++x) {
        energy[x - x_begin] +=
            step_energy(face[x], w[i + x], w[j + x]) +
            sibling_energy(face[x - along], w[i + x], f > 1 ? w[i - along + x] : (REAL)0) +
            sibling_energy(face[x + along], w[j + x], f + 1 < c ? w[j + along + x] : (REAL)0);
      }
      for (int upper = 0; upper < 2; ++upper) {
        const long cell = upper ? j : i;
        global const REAL* v = w + cell;
        global const REAL* west = gx + cell / nx * (nx + 1);
        global const REAL* low = g_other + cell + (axis == 1 ? 0 : (long)(at - 1 + upper) * nx);
        const int inside = max(x_begin, 1);
        add_mismatch(inside, x_end, energy + (inside - x_begin), west, v, v - 1);
        // Not min(x_end, nx - 1), which NVIDIA's compiler takes for x_end.
        const int before_last = x_end < nx ? x_end : nx - 1;
        add_mismatch(x_begin, before_last, energy, west + 1, v, v + 1);
        if (other > 0) add_mismatch(x_begin, x_end, energy, low, v, v - across);
        if (other + 1 < others) {
          add_mismatch(x_begin, x_end, energy, low + across, v, v + across);
        }
      }
    }
    if (half_x) {
      for (int k = 0; 2 * k < x_end - x_begin; ++k) {
        coarse[x_begin / 2 + k] = energy[2 * k] + energy[2 * k + 1];
      }
    } else {
      for (int k = 0; k < x_end - x_begin; ++k) coarse[x_begin + k] = energy[k];
    }
  }
}
