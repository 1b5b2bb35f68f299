// The regulariser of a block (roughness.h), H1 or Huber-TV, and what becomes of the data's gradient
// with it. `scale` is h/ℓ, `pull` that times (h/L)² or 0; those of log μ are a ninth.

#define VOXEL(i)                        \
  const size_t plane = (size_t)nx * ny; \
  const int x = (int)(i % nx), y = (int)(i / nx % ny), z = (int)(i / plane);

#define FOR_NEIGHBOURS(visit)    \
  if (x > 0) visit(i - 1);       \
  if (x + 1 < nx) visit(i + 1);  \
  if (y > 0) visit(i - nx);      \
  if (y + 1 < ny) visit(i + nx); \
  if (z > 0) visit(i - plane);   \
  if (z + 1 < nz) visit(i + plane);

// R, its terms voxel by voxel; of Huber-TV, of slope `edge` per voxel (0: H1), the diffusivity too.
REDUCTION void roughness(const int nx, const int ny, const int nz, const double edge,
                         const double per_mu, const double scale, const double pull,
                         const double to_kappa, const double to_mu,
                         global const double* restrict logs, global double* restrict diffusivity,
                         global double* restrict partial) {
  local double scratch[GROUP];
  const size_t cells = (size_t)nx * ny * nz;
  double sum = 0;
  FOR_ELEMENTS(i, cells) {
    VOXEL(i)
    const double k = logs[i], m = logs[i + cells];
    double steep = 0;  // |∇v|² h²
#define ADD_SQUARE(j)                                          \
  {                                                            \
    const double dk = k - logs[j], dm = m - logs[(j) + cells]; \
    steep += 0.5 * (dk * dk + per_mu * dm * dm);               \
  }
    FOR_NEIGHBOURS(ADD_SQUARE)
    if (edge > 0) {
      const double slope = sqrt(steep), least = fmin(slope, edge);
      diffusivity[i] = edge / fmax(slope, edge);
      sum += scale * least * (slope - 0.5 * least);
    } else {
      sum += scale * 0.5 * steep;
    }
    const double off_kappa = k - to_kappa, off_mu = m - to_mu;
    sum += 0.5 * pull * (off_kappa * off_kappa + per_mu * off_mu * off_mu);
  }
  leave(sum, 0, 0, scratch, partial);
}

// What flows from voxel i to its neighbours, of log κ's differences (x) and log μ's (y), each times
// the mean of both diffusivities (edges) or 1.
double2 flow_from(const size_t i, const int nx, const int ny, const int nz, const int edges,
                  global const double* restrict fields, global const double* restrict diffusivity) {
  const size_t cells = (size_t)nx * ny * nz;
  VOXEL(i)
  double2 sum = (double2)(0);
#define ADD_FLOW(j)                                                                    \
  {                                                                                    \
    const double flow = edges ? 0.5 * (diffusivity[i] + diffusivity[j]) : 1;           \
    sum.x += flow * (fields[i] - fields[j]);                                           \
    sum.y += flow * (fields[i + cells] - fields[(j) + cells]);                         \
  }
  FOR_NEIGHBOURS(ADD_FLOW)
  return sum;
}

// What the regulariser's quadratic form makes of `change` (smoothing_product()).
kernel void smoothing_product(const int nx, const int ny, const int nz, const int edges,
                              const double per_mu, const double scale, const double pull,
                              global const double* restrict diffusivity,
                              global const double* restrict change,
                              global double* restrict product) {
  const size_t i = get_global_id(0), cells = (size_t)nx * ny * nz;
  if (i >= cells) return;
  const double2 flow = flow_from(i, nx, ny, nz, edges, change, diffusivity);
  product[i] = scale * flow.x + pull * change[i];
  product[i + cells] = per_mu * (scale * flow.y + pull * change[i + cells]);
}

// Derivatives by log μ become those by w (absorption_scale.h), in place.
kernel void by_scaled(const int cells, const double log_scale, global const double* restrict logs,
                      global double* restrict by_logs) {
  ELEMENT(cells)
  by_logs[i + cells] /= cosh(logs[i + cells] - log_scale);
}

// Adds `weight` times R's gradient; then derivatives by log μ become those by w where log μ is not
// the coordinate itself (absorption_scale.h).
kernel void finish_gradient(const int nx, const int ny, const int nz, const int edges,
                            const double per_mu, const double weight, const double scale,
                            const double pull, const double to_kappa, const double to_mu,
                            const int scaled, const double log_scale,
                            global const double* restrict logs,
                            global const double* restrict diffusivity,
                            global double* restrict gradient) {
  const size_t i = get_global_id(0), cells = (size_t)nx * ny * nz;
  if (i >= cells) return;
  const double k = logs[i], m = logs[i + cells];
  const double2 flow = flow_from(i, nx, ny, nz, edges, logs, diffusivity);
  gradient[i] += weight * (scale * flow.x + pull * (k - to_kappa));
  const double sum = gradient[i + cells] + weight * per_mu * (scale * flow.y + pull * (m - to_mu));
  gradient[i + cells] = scaled ? sum / cosh(m - log_scale) : sum;
}
