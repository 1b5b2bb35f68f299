// Conductances of the finest level from κ and μ, of each coarser level from the finer one, and the
// weights of interpolation between them. All arrays are scalar, layouts as in grid_operator.cl.
#ifndef REAL
#define REAL float
#endif

// Boundary faces: G_b = h² / (h/(2κ) + 2A); 0 on mirrors.
REAL robin(REAL kappa, REAL h, REAL two_a, int open) {
  return open ? h * h / (h / (2 * kappa) + two_a) : (REAL)0;
}
REAL harmonic(REAL a, REAL b, REAL h) { return h * 2 * (a * b / (a + b)); }

// One item per row (y, z). open_x, open_y, open_z: whether the faces across that axis are open.
kernel void assemble(const int nx, const int ny, const int nz, const REAL h, const REAL two_a,
                     const int open_x, const int open_y, const int open_z,
                     global const REAL *restrict kappa, global const REAL *restrict mu,
                     global REAL *restrict gx, global REAL *restrict gy, global REAL *restrict gz,
                     global REAL *restrict sink) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= ny * nz) return;
  const int y = row % ny, z = row / ny;
  const size_t first = (size_t)row * nx;
  const size_t plane = (size_t)nx * ny;
  global REAL *face_x = gx + (size_t)row * (nx + 1);
  global REAL *face_y = gy + ((size_t)z * (ny + 1) + y) * nx;
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

// Half the resistance between the two children of a coarse cell, 0 where it has one child: `face`
// is the conductance between them.
REAL half_inside(global const REAL *face, size_t at, int has_two) {
  return has_two ? (REAL)0.5 / face[at] : (REAL)0;
}

// Coarse face conductances across one axis: per fine face a series of resistances from centre to
// centre, the fine faces of a coarse one in parallel. Axis `n` fine cells long (c coarse), stride
// `step` between faces along it; the other two axes p and q with extents np, nq and strides.
// One item per coarse (P, Q); faces X = 0..c along the axis.
kernel void coarsen_faces(const int n, const int c, const int np, const int nq, const int cp,
                          const int cq, const int step, const int step_p, const int step_q,
                          const int coarse_step, const int coarse_step_p, const int coarse_step_q,
                          global const REAL *restrict fine, global REAL *restrict coarse) {
  const int item = (int)get_global_id(1);
  if (get_global_id(0) > 0 || item >= cp * cq) return;
  const int cell_p = item % cp, cell_q = item / cp;
  const int p_end = min(2 * cell_p + 2, np), q_end = min(2 * cell_q + 2, nq);
  for (int face = 0; face <= c; ++face) {
    const int f = min(2 * face, n);
    const int two_before = face > 0 && 2 * face - 1 < n;
    const int two_after = 2 * face + 1 < n;
    REAL sum = 0;
    for (int q = 2 * cell_q; q < q_end; ++q) {
      for (int p = 2 * cell_p; p < p_end; ++p) {
        const size_t line = (size_t)p * step_p + (size_t)q * step_q;
        const size_t at = line + (size_t)f * step;
        const REAL g = fine[at];
        if (g > 0) {
          sum += 1 / (half_inside(fine, at - step, two_before) + 1 / g +
                      half_inside(fine, at + step, two_after));
        }
      }
    }
    coarse[(size_t)face * coarse_step + (size_t)cell_p * coarse_step_p +
           (size_t)cell_q * coarse_step_q] = sum;
  }
}

// Coarse S = sum over the children. One item per coarse row.
kernel void coarsen_sink(const int nx, const int ny, const int nz, const int cx, const int cy,
                         const int cz, global const REAL *restrict fine,
                         global REAL *restrict coarse) {
  const int row = (int)get_global_id(1);
  if (get_global_id(0) > 0 || row >= cy * cz) return;
  const int cell_y = row % cy, cell_z = row / cy;
  for (int cell_x = 0; cell_x < cx; ++cell_x) {
    REAL sum = 0;
    for (int z = 2 * cell_z; z < min(2 * cell_z + 2, nz); ++z) {
      for (int y = 2 * cell_y; y < min(2 * cell_y + 2, ny); ++y) {
        for (int x = 2 * cell_x; x < min(2 * cell_x + 2, nx); ++x) {
          sum += fine[((size_t)z * ny + y) * nx + x];
        }
      }
    }
    coarse[(size_t)row * cx + cell_x] = sum;
  }
}

// Interpolation weights across one axis (grid_transfer.cl), for every fine cell; arguments as in
// coarsen_faces, `cell_step...` being strides between cells. One item per fine (p, q).
kernel void weights(const int n, const int np, const int nq, const int step, const int step_p,
                    const int step_q, const int cell_step, const int cell_step_p,
                    const int cell_step_q, global const REAL *restrict fine,
                    global REAL *restrict weight) {
  const int item = (int)get_global_id(1);
  if (get_global_id(0) > 0 || item >= np * nq) return;
  const int p = item % np, q = item / np;
  const size_t line = (size_t)p * step_p + (size_t)q * step_q;
  for (int i = 0; i < n; ++i) {
    // Faces: `inner` between the siblings, `outer` to the coarse neighbour, `beyond` between the
    // neighbour's children.
    const int odd = i & 1;
    const int two_here = odd || i + 1 < n;
    const size_t inner = line + (size_t)(odd ? i : i + 1) * step;
    const int f = odd ? i + 1 : i;
    const int two_there = odd ? i + 2 < n : i > 0;
    const size_t beyond = line + (size_t)(odd ? i + 2 : max(i - 1, 0)) * step;
    const REAL g = fine[line + (size_t)f * step];
    const REAL here = half_inside(fine, inner, two_here);
    const REAL there = half_inside(fine, beyond, two_there);
    weight[(size_t)i * cell_step + (size_t)p * cell_step_p + (size_t)q * cell_step_q] =
        g > 0 ? here / (here + 1 / g + there) : (REAL)0;
  }
}
