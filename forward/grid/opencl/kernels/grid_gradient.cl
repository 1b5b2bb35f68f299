// A medium from the logarithms of its coefficients, and the gradient by them from sums over the
// patterns: forward/grid/gradient.cpp states the formulae. Pairs of fields are [2][z][y][x], log κ
// and log μ; everything but the solver's κ and μ, of the type STORED, is double (STORED). One item
// per voxel, pixel or column.
#ifndef STORED
#define STORED float
#endif

kernel void set_coefficients(const int cells, global const double* restrict logs,
                             global STORED* restrict kappa, global STORED* restrict mu) {
  const size_t i = get_global_id(0);
  if (i >= (size_t)cells) return;
  kappa[i] = (STORED)exp(logs[i]);
  mu[i] = (STORED)exp(logs[i + cells]);
}

// ∂G_ij/∂log κ_i times what crosses the face, G_ij = 2h κ_i κ_j/(κ_i + κ_j).
double across(const double product, const double kappa, const double log_here,
              const double log_there, const double h) {
  const double share = 1 / (1 + exp(log_here - log_there));
  return product * 2 * h * kappa * share * share;
}

// Sums of cells and faces; the terms of faces, cells and the boundary.
kernel void gradient_of_voxels(const int nx, const int ny, const int nz, const int open_x,
                               const int open_y, const int open_z, const double h, const double A,
                               global const double* restrict logs,
                               global const double* restrict cell,
                               global const double* restrict face_x,
                               global const double* restrict face_y,
                               global const double* restrict face_z,
                               global double* restrict gradient) {
  const size_t i = get_global_id(0), plane = (size_t)nx * ny, cells = plane * nz;
  if (i >= cells) return;
  const int x = (int)(i % nx), y = (int)(i / nx % ny), z = (int)(i / plane);
  const double here = logs[i], kappa = exp(here);
  double sum = 0;
  int open = 0;
#define SIDE(inside, product, neighbour, open_there)                                   \
  if (inside)                                                                          \
    sum += across(product, kappa, here, logs[neighbour], h);                           \
  else                                                                                 \
    open += open_there;
  SIDE(x > 0, face_x[i - 1], i - 1, open_x)
  SIDE(x + 1 < nx, face_x[i], i + 1, open_x)
  SIDE(y > 0, face_y[i - nx], i - nx, open_y)
  SIDE(y + 1 < ny, face_y[i], i + nx, open_y)
  SIDE(z > 0, face_z[i - plane], i - plane, open_z)
  SIDE(z + 1 < nz, face_z[i], i + plane, open_z)
#undef SIDE
  const double conductance = robin_conductance(kappa, h, A);
  sum += open * conductance * conductance / (2 * h * kappa) * cell[i];
  gradient[i] -= sum;
  gradient[i + cells] -= h * h * h * exp(logs[i + cells]) * cell[i];
}

// Sample (u, v) of a face touches voxel first + u cell_u + v cell_v.
#define PIXEL                                                                             \
  const int k = (int)get_global_id(0);                                                    \
  if (k >= nu * nv) return;                                                               \
  const size_t i = (size_t)first + (size_t)(k % nu) * cell_u + (size_t)(k / nu) * cell_v; \
  const double kappa = exp(logs[i]);                                                      \
  const double conductance = robin_conductance(kappa, h, A), slope = conductance / (2 * h * kappa);

// What is seen is proportional to the conductance of the seen face.
kernel void gradient_of_seen(const int nu, const int nv, const int first, const int cell_u,
                             const int cell_v, const double h, const double A,
                             const int observed_first, global const double* restrict logs,
                             global const double* restrict observed,
                             global double* restrict gradient) {
  PIXEL
  gradient[i] += slope * observed[observed_first + k];
}

// Light that enters through the boundary condition; `columns` as of column_products.
kernel void gradient_of_entry(const int nu, const int nv, const int first, const int cell_u,
                              const int cell_v, const double h, const double A, const double q,
                              global const double* restrict logs,
                              global const double* restrict columns,
                              global double* restrict gradient) {
  PIXEL
  gradient[i] += conductance * slope * q * columns[i];
}

// First collisions along each column (forward/light/beam_column.h states the recurrences). The
// scratch holds, of cell w of column k at [w][k], the share that collides and what the passages
// away and back bring to the cell.
kernel void gradient_of_beam(const int nu, const int nv, const int depth, const int first,
                             const int cell_u, const int cell_v, const int inwards, const int cells,
                             const double h, const double reflectance, const double scale,
                             global const double* restrict logs,
                             global const double* restrict columns, global double* restrict share,
                             global double* restrict away, global double* restrict back,
                             global double* restrict gradient) {
  const int k = (int)get_global_id(0), count = nu * nv;
  if (k >= count) return;
  const size_t start = (size_t)first + (size_t)(k % nu) * cell_u + (size_t)(k / nu) * cell_v;
#define CELL ((size_t)(start + (long)w * inwards))
#define AT ((size_t)w * count + k)
  double passes = 1;
  for (int w = 0; w < depth; ++w) {
    share[AT] = -expm1(-h / (3 * exp(logs[CELL])));
    passes *= 1 - share[AT];
  }
  const double round_trip = reflectance * passes, series = 1 / (1 - round_trip * round_trip);
  double passing = series;
  for (int w = 0; w < depth; ++w) {
    away[AT] = passing;
    passing *= 1 - share[AT];
  }
  passing = round_trip * series;
  const double more = 2 * round_trip * passing;
  double behind_away = 0, behind_back = 0;  // weighted collisions behind the cell
  for (int w = depth - 1; w >= 0; --w) {
    back[AT] = passing;
    passing *= 1 - share[AT];
    const double absorbed = 3 * exp(logs[CELL] + logs[CELL + cells]);
    const double weight = scale * columns[CELL] * fmax(0.0, 1 - absorbed);
    const double collided = (away[AT] + back[AT]) * share[AT];
    const double by_albedo = absorbed < 1 ? -absorbed * scale * columns[CELL] * collided : 0;
    const double by_thickness = (1 - share[AT]) * (away[AT] + back[AT]) * weight - behind_away;
    gradient[CELL] += by_albedo - h / (3 * exp(logs[CELL])) * by_thickness;
    gradient[CELL + cells] += by_albedo;
    behind_away += weight * away[AT] * share[AT];
    behind_back += weight * back[AT] * share[AT];
  }
  double before = more * (behind_away + behind_back) + behind_back;
  for (int w = 0; w < depth; ++w) {
    const double absorbed = 3 * exp(logs[CELL] + logs[CELL + cells]);
    const double weight = scale * columns[CELL] * fmax(0.0, 1 - absorbed);
    gradient[CELL] += h / (3 * exp(logs[CELL])) * before;
    before += weight * back[AT] * share[AT];
  }
}
