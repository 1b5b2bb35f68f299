// First collisions of a collimated beam that enters normal to a face: the share of a column's light
// that scatters in each voxel for the first time, (σs'/σt') (e^(−τ_in) − e^(−τ_out)) with
// σt' = 1/(3κ), on its way to the far face, back, and so on. With R reflected at each face and p
// passing a column, the ways there sum to D = 1/(1 − R²p²) and those back to U = R p D
// (forward/light/beam_column.h). Eight columns at a time: a vector of exponentials costs little
// more than one.
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

// What comes back is left out where it is less of the light than REAL rounds away.
#define LEAST_BACK (sizeof(REAL) == 4 ? 1e-8f : 1e-17f)

// What eight voxels take of the light that meets them, and what they scatter of that.
ACCU8 collide(global const REAL* kappa, global const REAL* mu, const REAL h, const int stride,
              const int count, ACCU8* albedo) {
  const ACCU8 k = 3 * load_columns(kappa, stride, count);
  *albedo = max((ACCU8)(0), 1 - k * load_columns(mu, stride, count));
  // expm1 keeps thin voxels accurate, where the two exponentials nearly cancel.
  return -expm1(-(ACCU)h / k);
}

// A voxel at depth w below sample (u, v) of the face is first + u cell_u + v cell_v + w cell_w. One
// item per row v of the face, or on GPUs per eight columns of it; `remaining` [v][u, nu rounded up
// to a multiple of 8] is scratch: what has not collided yet.
kernel void first_collisions(const int nu, const int nv, const int depth, const int first,
                             const int cell_u, const int cell_v, const int cell_w, const REAL h,
                             const REAL reflectance, global const REAL* restrict kappa,
                             global const REAL* restrict mu, global REAL* restrict share,
                             global ACCU* restrict remaining) {
  const int groups = (nu + 7) / 8;
  FOR_ROW_OF(groups, nv)
  const int v = row;
  remaining += (size_t)v * groups * 8;
  for (int u = 8 * begin; u < 8 * end; ++u) remaining[u] = 1;
  for (int w = 0; w < depth; ++w) {
    for (int group = begin; group < end; ++group) {
      const int u = 8 * group, count = min(8, nu - u);
      const size_t i = (size_t)(first + u * cell_u + v * cell_v + w * cell_w);
      ACCU8 albedo;
      const ACCU8 lost = collide(kappa + i, mu + i, h, cell_u, count, &albedo);
      const ACCU8 left = vload8(group, remaining);
      store_columns(to_real8(albedo * left * lost), share + i, cell_u, count);
      vstore8(left * (1 - lost), group, remaining);
    }
  }
  for (int group = begin; group < end; ++group) {
    const int u = 8 * group, count = min(8, nu - u);
    const ACCU8 round_trip = reflectance * vload8(group, remaining);
    if (!any(round_trip > LEAST_BACK)) continue;
    const ACCU8 there = 1 / (1 - round_trip * round_trip);
    ACCU8 back = round_trip * there;
    for (int w = depth - 1; w >= 0; --w) {
      const size_t i = (size_t)(first + u * cell_u + v * cell_v + w * cell_w);
      ACCU8 albedo;
      const ACCU8 lost = collide(kappa + i, mu + i, h, cell_u, count, &albedo);
      const ACCU8 fresh = there * load_columns(share + i, cell_u, count);
      store_columns(to_real8(fresh + albedo * back * lost), share + i, cell_u, count);
      back *= 1 - lost;
    }
  }
}
