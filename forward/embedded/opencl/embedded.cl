// Multigrid and conjugate gradients on cubes in Morton order, matrix-free: a product is made cube
// by cube from element matrices (equations/levels.h), left in the slots of the cubes' corners, and
// collected unknown by unknown. Nothing is written by two items, sums run in a fixed order.
//
// Compiled twice: CYCLE 1 with REAL float is the V-cycle, CYCLE 0 with REAL double what is outside.

typedef LANES_OF(float) single_vec;
typedef LANES_OF(double) double_vec;

// The value at a cube's corner: of an unknown, or the mean of two or four where the corner hangs.
inline vec corner_value(const int code, global const int* restrict masters,
                        global const vec* restrict x) {
  if (code >= 0) return x[code];
  global const int* of = masters + ~code;
  const vec pair = x[of[1]] + x[of[2]];
  return of[0] == 2 ? (REAL)0.5 * pair : (REAL)0.25 * (pair + x[of[3]] + x[of[4]]);
}

// slots[8 cube + i] = Σ_j a_ij x_j.
kernel void cube_products(const int cubes, global const int8* restrict corner,
                          global const int* restrict masters, global const int* restrict place,
                          global const own* restrict element, global const vec* restrict x,
                          global vec* restrict slots) {
  ITEM(cubes)
  const int8 codes = corner[i];
  const vec x0 = corner_value(codes.s0, masters, x), x1 = corner_value(codes.s1, masters, x),
            x2 = corner_value(codes.s2, masters, x), x3 = corner_value(codes.s3, masters, x),
            x4 = corner_value(codes.s4, masters, x), x5 = corner_value(codes.s5, masters, x),
            x6 = corner_value(codes.s6, masters, x), x7 = corner_value(codes.s7, masters, x);
  global const own* a = element + (size_t)place[i] * 36;
  global vec* y = slots + (size_t)i * 8;
  // The upper half row by row.
  y[0] =
      a[0] * x0 + a[1] * x1 + a[2] * x2 + a[3] * x3 + a[4] * x4 + a[5] * x5 + a[6] * x6 + a[7] * x7;
  y[1] = a[1] * x0 + a[8] * x1 + a[9] * x2 + a[10] * x3 + a[11] * x4 + a[12] * x5 + a[13] * x6 +
         a[14] * x7;
  y[2] = a[2] * x0 + a[9] * x1 + a[15] * x2 + a[16] * x3 + a[17] * x4 + a[18] * x5 + a[19] * x6 +
         a[20] * x7;
  y[3] = a[3] * x0 + a[10] * x1 + a[16] * x2 + a[21] * x3 + a[22] * x4 + a[23] * x5 + a[24] * x6 +
         a[25] * x7;
  y[4] = a[4] * x0 + a[11] * x1 + a[17] * x2 + a[22] * x3 + a[26] * x4 + a[27] * x5 + a[28] * x6 +
         a[29] * x7;
  y[5] = a[5] * x0 + a[12] * x1 + a[18] * x2 + a[23] * x3 + a[27] * x4 + a[30] * x5 + a[31] * x6 +
         a[32] * x7;
  y[6] = a[6] * x0 + a[13] * x1 + a[19] * x2 + a[24] * x3 + a[28] * x4 + a[31] * x5 + a[33] * x6 +
         a[34] * x7;
  y[7] = a[7] * x0 + a[14] * x1 + a[20] * x2 + a[25] * x3 + a[29] * x4 + a[32] * x5 + a[34] * x6 +
         a[35] * x7;
}

// What the cubes about an unknown left for it; a corner that hangs gives each of its two or four
// its share. part = 4 slot + log2(count).
inline vec collected(const int unknown, global const int* restrict start,
                     global const int* restrict part, global const vec* restrict slots) {
  vec sum = (vec)(0);
  const int end = start[unknown + 1];
  for (int k = start[unknown]; k < end; ++k) {
    const int code = part[k];
    const REAL weight = (code & 3) == 0 ? (REAL)1 : (code & 3) == 1 ? (REAL)0.5 : (REAL)0.25;
    sum += weight * slots[code >> 2];
  }
  return sum;
}

// out = A x, after cube_products.
kernel void collect(const int unknowns, global const int* restrict start,
                    global const int* restrict part, global const vec* restrict slots,
                    global vec* restrict out) {
  ITEM(unknowns)
  out[i] = collected(i, start, part, slots);
}

#if CYCLE

// r −= A z, after cube_products of z.
kernel void subtract(const int unknowns, global const int* restrict start,
                     global const int* restrict part, global const vec* restrict slots,
                     global vec* restrict r) {
  ITEM(unknowns)
  r[i] -= collected(i, start, part, slots);
}

// The smoother's first step (linear_solver.h): z = gain r/d, added to x, or its value where x is
// still zero.
kernel void smooth_first(const int unknowns, const float gain, const int x_is_zero,
                         global const own* restrict inverse_scale, global const vec* restrict r,
                         global vec* restrict z, global vec* restrict x) {
  ITEM(unknowns)
  const vec step = gain * inverse_scale[i] * r[i];
  z[i] = step;
  x[i] = x_is_zero ? step : x[i] + step;
}

// A later one, after cube_products of z.
kernel void smooth_next(const int unknowns, const float keep, const float gain,
                        global const int* restrict start, global const int* restrict part,
                        global const vec* restrict slots, global const own* restrict inverse_scale,
                        global vec* restrict r, global vec* restrict z, global vec* restrict x) {
  ITEM(unknowns)
  const vec residual = r[i] - collected(i, start, part, slots);
  const vec step = (REAL)keep * z[i] + (REAL)gain * inverse_scale[i] * residual;
  r[i] = residual;
  z[i] = step;
  x[i] += step;
}

// Weight of the parent's shape function j at corner c of its child `octant`: ½ per axis where the
// corner lies between the parent's.
inline REAL parent_weight(const int octant, const int c, const int j) {
  REAL weight = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const int o = octant >> axis & 1, at = c >> axis & 1, to = j >> axis & 1;
    weight *= o != at ? (REAL)0.5 : at == to ? (REAL)1 : (REAL)0;
  }
  return weight;
}

// slots[8 coarse cube + j] = Σ r of the unknowns that its cubes own, times the shape functions
// there. owned: a bit per corner of a fine cube that owns its unknown.
kernel void restrict_cubes(const int coarse_cubes, global const int* restrict first_child,
                           global const int* restrict octant, global const uchar* restrict owned,
                           global const int* restrict corner, global const vec* restrict r,
                           global vec* restrict slots) {
  ITEM(coarse_cubes)
  vec sum[8];
  for (int j = 0; j < 8; ++j) sum[j] = (vec)(0);
  for (int child = first_child[i]; child < first_child[i + 1]; ++child) {
    const int bits = owned[child];
    for (int c = 0; c < 8; ++c) {
      if ((bits >> c & 1) == 0) continue;
      const vec value = r[corner[8 * child + c]];
      if (octant[child] < 0) {
        sum[c] += value;
      } else {
        for (int j = 0; j < 8; ++j) sum[j] += parent_weight(octant[child], c, j) * value;
      }
    }
  }
  for (int j = 0; j < 8; ++j) slots[(size_t)i * 8 + j] = sum[j];
}

// z = coarse correction at the fine unknowns, added to x. owner: 8 cube + corner.
kernel void prolong(const int unknowns, global const int* restrict owner,
                    global const int* restrict parent, global const int* restrict octant,
                    global const int* restrict coarse_corner,
                    global const int* restrict coarse_masters, global const vec* restrict coarse,
                    global vec* restrict z, global vec* restrict x) {
  ITEM(unknowns)
  const int cube = owner[i] >> 3, c = owner[i] & 7;
  global const int* codes = coarse_corner + 8 * parent[cube];
  vec sum = (vec)(0);
  if (octant[cube] < 0) {
    sum = corner_value(codes[c], coarse_masters, coarse);
  } else {
    for (int j = 0; j < 8; ++j) {
      const REAL weight = parent_weight(octant[cube], c, j);
      if (weight > 0) sum += weight * corner_value(codes[j], coarse_masters, coarse);
    }
  }
  z[i] = sum;
  x[i] += sum;
}

// x = A⁻¹ r on the coarsest level.
kernel void solve_directly(const int unknowns, global const own* restrict inverse,
                           global const vec* restrict r, global vec* restrict x) {
  ITEM(unknowns)
  vec sum = (vec)(0);
  for (int k = 0; k < unknowns; ++k) sum += inverse[(size_t)i * unknowns + k] * r[k];
  x[i] = sum;
}

#else

// Conjugate gradients: vectors in double, a scalar per lane.

kernel void fill(const int rows, const double value, global double_vec* restrict a) {
  ITEM(rows)
  a[i] = (double_vec)(value);
}

kernel void dot_double(const int rows, const int runs, global const double_vec* restrict a,
                       global const double_vec* restrict b, global double_vec* restrict partial) {
  RUN(rows)
  double_vec sum = (double_vec)(0);
  for (int k = begin; k < end; k += step_over) sum += a[k] * b[k];
  partial[run] = sum;
}

// Of r with the V-cycle's answer.
kernel void dot_single(const int rows, const int runs, global const double_vec* restrict a,
                       global const single_vec* restrict b, global double_vec* restrict partial) {
  RUN(rows)
  double_vec sum = (double_vec)(0);
  for (int k = begin; k < end; k += step_over) sum += a[k] * TO(double)(b[k]);
  partial[run] = sum;
}

// The V-cycle's residual: of length one, so that single precision neither over- nor underflows.
kernel void to_single(const int rows, global const double_vec* restrict inverse_size,
                      global const double_vec* restrict r, global single_vec* restrict out) {
  ITEM(rows)
  out[i] = TO(float)(r[i] * inverse_size[0]);
}

// p = size z + along p, scalars = {size, along}.
kernel void update_direction(const int rows, global const double_vec* restrict scalars,
                             global const single_vec* restrict z, global double_vec* restrict p) {
  ITEM(rows)
  p[i] = scalars[0] * TO(double)(z[i]) + scalars[1] * p[i];
}

// x += step p, r −= step q; partial = Σ r².
kernel void update_solution(const int rows, const int runs, global const double_vec* restrict step,
                            global const double_vec* restrict p,
                            global const double_vec* restrict q, global double_vec* restrict x,
                            global double_vec* restrict r, global double_vec* restrict partial) {
  RUN(rows)
  double_vec sum = (double_vec)(0);
  for (int k = begin; k < end; k += step_over) {
    x[k] += step[0] * p[k];
    const double_vec residual = r[k] - step[0] * q[k];
    r[k] = residual;
    sum += residual * residual;
  }
  partial[run] = sum;
}

#endif
