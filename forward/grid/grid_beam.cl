// First collisions of a collimated beam that enters normal to a face: the share of a column's light
// that scatters in each voxel for the first time, (σs'/σt') (e^(−τ_in) − e^(−τ_out)) with
// σt' = 1/(3κ). A voxel at depth w below sample (u, v) of the face is
// first + u cell_u + v cell_v + w cell_w. One item per row v of the face; `remaining` [v][u] is
// scratch: what has not collided yet.
kernel void first_collisions(const int nu, const int nv, const int depth, const int first,
                             const int cell_u, const int cell_v, const int cell_w, const REAL h,
                             global const REAL* restrict kappa, global const REAL* restrict mu,
                             global REAL* restrict share, global ACCU* restrict remaining) {
  const int v = (int)get_global_id(1);
  if (get_global_id(0) > 0 || v >= nv) return;
  remaining += (size_t)v * nu;
  for (int u = 0; u < nu; ++u) remaining[u] = 1;
  for (int w = 0; w < depth; ++w) {
    for (int u = 0; u < nu; ++u) {
      const size_t i = (size_t)(first + u * cell_u + v * cell_v + w * cell_w);
      const ACCU thickness = h / (3 * (ACCU)kappa[i]);
      const ACCU albedo = max((ACCU)0, 1 - 3 * (ACCU)kappa[i] * mu[i]);
      // expm1 keeps thin voxels accurate, where the two exponentials nearly cancel.
      share[i] = (REAL)(-albedo * remaining[u] * expm1(-thickness));
      remaining[u] *= exp(-thickness);
    }
  }
}
