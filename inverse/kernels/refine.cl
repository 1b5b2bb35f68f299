// Between a grid and one of half its voxels' edge; the finer one may end within the last coarse
// voxels.

// Pairs of fields, every voxel split: log κ and log μ less what they are lowered by.
kernel void split_voxels(const int nx, const int ny, const int nz, const int coarse_nx,
                         const int coarse_ny, const int coarse_nz, const double lower_kappa,
                         const double lower_mu, global const double* restrict coarse,
                         global double* restrict fine) {
  const size_t i = get_global_id(0), cells = (size_t)nx * ny * nz;
  if (i >= cells) return;
  const int x = (int)(i % nx), y = (int)(i / nx % ny), z = (int)(i / ((size_t)nx * ny));
  const size_t from = ((size_t)(z / 2) * coarse_ny + y / 2) * coarse_nx + x / 2;
  fine[i] = coarse[from] - lower_kappa;
  fine[i + cells] = coarse[from + (size_t)coarse_nx * coarse_ny * coarse_nz] - lower_mu;
}

// Means over the finer pixels that each pixel of so many maps covers.
kernel void restrict_maps(const int maps, const int nu, const int nv, const int coarse_nu,
                          const int coarse_nv, global const double* restrict fine,
                          global double* restrict coarse) {
  const size_t i = get_global_id(0), pixels = (size_t)coarse_nu * coarse_nv;
  if (i >= maps * pixels) return;
  const int u = 2 * (int)(i % coarse_nu), v = 2 * (int)(i / coarse_nu % coarse_nv);
  fine += i / pixels * nu * nv;
  double sum = 0;
  int count = 0;
  for (int b = v; b < min(v + 2, nv); ++b) {
    for (int a = u; a < min(u + 2, nu); ++a) {
      sum += fine[(size_t)b * nu + a];
      ++count;
    }
  }
  coarse[i] = sum / count;
}
