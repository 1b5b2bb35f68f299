// First collisions of a collimated beam that enters normal to a face: the share of a column's light
// that scatters in each voxel for the first time, (σs'/σt') (e^(−τ_in) − e^(−τ_out)) with
// σt' = 1/(3κ). Eight columns at a time: a vector of exponentials costs little more than one.
#define REAL8 JOIN(REAL, 8)
#define ACCU8 JOIN(ACCU, 8)
#define to_real8 JOIN(convert_, REAL8)
#define to_accu8 JOIN(convert_, ACCU8)

// The values of `count` columns, at most eight and `stride` apart; lanes past them repeat the last.
ACCU8 load_columns(global const REAL* values, const int stride, const int count) {
  if (stride == 1 && count == 8) return to_accu8(vload8(0, values));
  REAL lane[8];
  for (int k = 0; k < 8; ++k) lane[k] = values[(size_t)min(k, count - 1) * stride];
  return to_accu8(vload8(0, lane));
}

void store_columns(const REAL8 columns, global REAL* values, const int stride, const int count) {
  if (stride == 1 && count == 8) {
    vstore8(columns, 0, values);
    return;
  }
  REAL lane[8];
  vstore8(columns, 0, lane);
  for (int k = 0; k < count; ++k) values[(size_t)k * stride] = lane[k];
}

// A voxel at depth w below sample (u, v) of the face is first + u cell_u + v cell_v + w cell_w. One
// item per row v of the face, or on GPUs per eight columns of it; `remaining` [v][u, nu rounded up
// to a multiple of 8] is scratch: what has not collided yet.
kernel void first_collisions(const int nu, const int nv, const int depth, const int first,
                             const int cell_u, const int cell_v, const int cell_w, const REAL h,
                             global const REAL* restrict kappa, global const REAL* restrict mu,
                             global REAL* restrict share, global ACCU* restrict remaining) {
  const int groups = (nu + 7) / 8;
  FOR_ROW_OF(groups, nv)
  const int v = row;
  remaining += (size_t)v * groups * 8;
  for (int u = 8 * begin; u < 8 * end; ++u) remaining[u] = 1;
  for (int w = 0; w < depth; ++w) {
    for (int group = begin; group < end; ++group) {
      const int u = 8 * group, count = min(8, nu - u);
      const size_t i = (size_t)(first + u * cell_u + v * cell_v + w * cell_w);
      const ACCU8 k = 3 * load_columns(kappa + i, cell_u, count);
      const ACCU8 albedo = max((ACCU8)(0), 1 - k * load_columns(mu + i, cell_u, count));
      // expm1 keeps thin voxels accurate, where the two exponentials nearly cancel.
      const ACCU8 lost = -expm1(-(ACCU)h / k);
      const ACCU8 left = vload8(group, remaining);
      store_columns(to_real8(albedo * left * lost), share + i, cell_u, count);
      vstore8(left * (1 - lost), group, remaining);
    }
  }
}
