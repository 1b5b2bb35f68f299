// Multigrid and conjugate gradients on row matrices (row_matrix.h). Nothing is written by two items,
// sums run in a fixed order.
//
// Compiled twice: CYCLE 1 with REAL float is the V-cycle, CYCLE 0 with REAL double what is outside.
// Entries lie in slices of SLICE rows: the first entries of all of them, then the second, and so on,
// with zeros where a row has fewer. GPUs read the entries of neighbouring rows at once; processors
// have slices of one row.
#ifndef SLICE
#define SLICE 1
#endif

typedef LANES_OF(float) single_vec;
typedef LANES_OF(double) double_vec;

// sum = Σ_k value_k x_column(k) over a row of the matrix `start`, `column`, `value`.
#define ROW_SUM(row, value, x)                                                           \
  vec sum = (vec)(0);                                                                    \
  for (uint k = start[row / SLICE] + row % SLICE; k < start[row / SLICE + 1]; k += SLICE) \
    sum += value[k] * x[column[k]];

#if CYCLE

// The operations of v_cycle.h.

kernel void smooth_first(const int rows, const float gain, const int x_is_zero,
                         global const own* restrict inverse_scale, global const vec* restrict r,
                         global vec* restrict z, global vec* restrict x) {
  ITEM(rows)
  const vec step = gain * inverse_scale[i] * r[i];
  z[i] = step;
  x[i] = x_is_zero ? step : x[i] + step;
}

kernel void smooth_next(const int rows, const float keep, const float gain,
                        global const uint* restrict start, global const int* restrict column,
                        global const own* restrict value, global const own* restrict inverse_scale,
                        global vec* restrict r, global const vec* restrict z,
                        global vec* restrict next, global vec* restrict x) {
  ITEM(rows)
  ROW_SUM(i, value, z)
  const vec residual = r[i] - sum;
  const vec step = keep * z[i] + gain * inverse_scale[i] * residual;
  r[i] = residual;
  next[i] = step;
  x[i] += step;
}

kernel void subtract_product(const int rows, global const uint* restrict start,
                             global const int* restrict column, global const own* restrict value,
                             global const vec* restrict z, global vec* restrict r) {
  ITEM(rows)
  ROW_SUM(i, value, z)
  r[i] -= sum;
}

kernel void restrict_to(const int rows, global const uint* restrict start,
                        global const int* restrict column, global const float* restrict value,
                        global const vec* restrict fine, global vec* restrict r) {
  ITEM(rows)
  ROW_SUM(i, value, fine)
  r[i] = sum;
}

kernel void prolong_to(const int rows, global const uint* restrict start,
                       global const int* restrict column, global const float* restrict value,
                       global const vec* restrict coarse, global vec* restrict z,
                       global vec* restrict x) {
  ITEM(rows)
  ROW_SUM(i, value, coarse)
  z[i] = sum;
  x[i] += sum;
}

kernel void solve_directly(const int rows, global const own* restrict inverse,
                           global const vec* restrict r, global vec* restrict x) {
  ITEM(rows)
  vec sum = (vec)(0);
  // The inverse is symmetric: a GPU's neighbouring items read neighbouring numbers.
  for (int k = 0; k < rows; ++k) {
    sum += inverse[SLICE > 1 ? (size_t)k * rows + i : (size_t)i * rows + k] * r[k];
  }
  x[i] = sum;
}

#else

// Conjugate gradients: vectors in double, a scalar per lane.

// q = A x.
kernel void product(const int rows, global const uint* restrict start,
                    global const int* restrict column, global const own* restrict value,
                    global const vec* restrict x, global vec* restrict q) {
  ITEM(rows)
  ROW_SUM(i, value, x)
  q[i] = sum;
}

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
kernel void to_single(const int rows, global const double_vec* restrict scalars,
                      global const double_vec* restrict r, global single_vec* restrict out) {
  ITEM(rows)
  out[i] = TO(float)(r[i] / scalars[CG_LENGTH]);
}

// p = length z + along p.
kernel void update_direction(const int rows, global const double_vec* restrict scalars,
                             global const single_vec* restrict z, global double_vec* restrict p) {
  ITEM(rows)
  p[i] = scalars[CG_LENGTH] * TO(double)(z[i]) + scalars[CG_ALONG] * p[i];
}

// x += step p, r −= step q, the step being the scalar at `place`; partial = Σ r².
kernel void update_solution(const int rows, const int runs, const int place,
                            global const double_vec* restrict scalars,
                            global const double_vec* restrict p,
                            global const double_vec* restrict q, global double_vec* restrict x,
                            global double_vec* restrict r, global double_vec* restrict partial) {
  RUN(rows)
  const double_vec step = scalars[place];
  double_vec sum = (double_vec)(0);
  for (int k = begin; k < end; k += step_over) {
    x[k] += step * p[k];
    const double_vec residual = r[k] - step * q[k];
    r[k] = residual;
    sum += residual * residual;
  }
  partial[run] = sum;
}

#endif
