// Conjugate gradients on sparse rows, and a V-cycle on the aggregates of a graph with one step of
// Jacobi before and after. Every item writes its own row; sums run in a fixed order.
//
// SUM is what sums are added up in.

#ifndef SUM
#define SUM double
#endif

typedef LANES_OF(SUM) sum_vec;

// Jacobi's, before and after the coarse correction: of 1, 2 and 3 steps of Chebyshev's polynomial of
// the fourth kind on [0, 2] (Lottes 2023) the first takes the least work.
#define STEP ((REAL)2 / 3)

// Row i of the matrix times x.
inline vec row_product(const int i, global const int* restrict start,
                       global const int* restrict column, global const own* restrict value,
                       global const vec* restrict x) {
  vec sum = (vec)(0);
  const int end = start[i + 1];
  for (int k = start[i]; k < end; ++k) sum += value[k] * x[column[k]];
  return sum;
}

// Jacobi's step from zero: y = step r/d. On every level it is kept beside r.
#define SMOOTHED(r) (STEP * inverse_diagonal[i] * (r))

// r = b − A x.
kernel void residual(const int rows, global const int* restrict start,
                     global const int* restrict column, global const own* restrict value,
                     global const own* restrict inverse_diagonal, global const vec* restrict b,
                     global const vec* restrict x, global vec* restrict r,
                     global vec* restrict y) {
  ITEM(rows)
  r[i] = b[i] - row_product(i, start, column, value, x);
  y[i] = SMOOTHED(r[i]);
}

// out = A x.
kernel void product(const int rows, global const int* restrict start,
                    global const int* restrict column, global const own* restrict value,
                    global const vec* restrict x, global vec* restrict out) {
  ITEM(rows)
  out[i] = row_product(i, start, column, value, x);
}

// Down the V-cycle: coarse r = Σ over an aggregate's nodes of the residual after Jacobi's step:
// r − (d y − Σ w y_n) = (1 − step) r + Σ w y_n.
kernel void down(const int aggregates, global const int* restrict first_child,
                 global const int* restrict child, global const int* restrict start,
                 global const int* restrict column, global const own* restrict link,
                 global const vec* restrict r, global const vec* restrict y,
                 global const own* restrict inverse_diagonal, global vec* restrict coarse_r,
                 global vec* restrict coarse_y) {
  ITEM(aggregates)
  vec sum = (vec)(0);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) {
    const int row = child[c];
    sum += ((REAL)1 - STEP) * r[row] + row_product(row, start, column, link, y);
  }
  coarse_r[i] = sum;
  coarse_y[i] = SMOOTHED(sum);
}

// Up again, y with the coarser level's correction: x = y + step (r − A y)/d.
inline vec after_correction(const int i, global const int* restrict start,
                            global const int* restrict column, global const own* restrict link,
                            global const own* restrict inverse_diagonal,
                            global const vec* restrict r, global const vec* restrict y) {
  const vec inflow = row_product(i, start, column, link, y);
  return y[i] + STEP * (inverse_diagonal[i] * (r[i] + inflow) - y[i]);
}

kernel void up(const int rows, global const int* restrict start,
               global const int* restrict column, global const own* restrict link,
               global const own* restrict inverse_diagonal, global const vec* restrict r,
               global const vec* restrict y, global vec* restrict x) {
  ITEM(rows)
  x[i] = after_correction(i, start, column, link, inverse_diagonal, r, y);
}

// On a coarser level: x corrects the finer level's nodes.
kernel void up_to_children(const int rows, global const int* restrict start,
                           global const int* restrict column, global const own* restrict link,
                           global const own* restrict inverse_diagonal,
                           global const vec* restrict r, global const vec* restrict y,
                           global const int* restrict first_child,
                           global const int* restrict child, global vec* restrict fine_y) {
  ITEM(rows)
  const vec x = after_correction(i, start, column, link, inverse_diagonal, r, y);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) fine_y[child[c]] += x;
}

// x = A⁻¹ r on the coarsest level.
inline vec direct(const int i, const int rows, global const own* restrict inverse,
                  global const vec* restrict r) {
  vec sum = (vec)(0);
  for (int k = 0; k < rows; ++k) sum += inverse[(size_t)k * rows + i] * r[k];
  return sum;
}

kernel void solve_directly(const int rows, global const own* restrict inverse,
                           global const vec* restrict r, global vec* restrict x) {
  ITEM(rows)
  x[i] = direct(i, rows, inverse, r);
}

kernel void direct_to_children(const int rows, global const own* restrict inverse,
                               global const vec* restrict r, global const int* restrict first_child,
                               global const int* restrict child, global vec* restrict fine_y) {
  ITEM(rows)
  const vec x = direct(i, rows, inverse, r);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) fine_y[child[c]] += x;
}

kernel void dot_product(const int rows, const int runs, global const vec* restrict a,
                        global const vec* restrict b, global sum_vec* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  for (int k = begin; k < end; k += step_over) sum += TO(SUM)(a[k] * b[k]);
  partial[run] = sum;
}

// p = z + along p.
kernel void update_direction(const int rows, global const sum_vec* restrict along,
                             global const vec* restrict z, global vec* restrict p) {
  ITEM(rows)
  p[i] = z[i] + TO(REAL)(along[0]) * p[i];
}

// x += step p, r −= step q; partial = Σ r².
kernel void update_solution(const int rows, const int runs,
                            global const sum_vec* restrict times,
                            global const own* restrict inverse_diagonal,
                            global const vec* restrict p, global const vec* restrict q,
                            global vec* restrict x, global vec* restrict r, global vec* restrict y,
                            global sum_vec* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  const vec by = TO(REAL)(times[0]);
  for (int i = begin; i < end; i += step_over) {
    x[i] += by * p[i];
    const vec left = r[i] - by * q[i];
    r[i] = left;
    y[i] = SMOOTHED(left);
    sum += TO(SUM)(left * left);
  }
  partial[run] = sum;
}

// Products of b with itself and with four images of former answers.
kernel void products_with_images(const int rows, const int runs, global const vec* restrict b,
                                 global const vec* restrict image_0,
                                 global const vec* restrict image_1,
                                 global const vec* restrict image_2,
                                 global const vec* restrict image_3,
                                 global sum_vec* restrict partial) {
  RUN(rows)
  sum_vec sum[5] = {(sum_vec)(0), (sum_vec)(0), (sum_vec)(0), (sum_vec)(0), (sum_vec)(0)};
  for (int i = begin; i < end; i += step_over) {
    const vec mine = b[i];
    sum[0] += TO(SUM)(mine * mine);
    sum[1] += TO(SUM)(mine * image_0[i]);
    sum[2] += TO(SUM)(mine * image_1[i]);
    sum[3] += TO(SUM)(mine * image_2[i]);
    sum[4] += TO(SUM)(mine * image_3[i]);
  }
  for (int k = 0; k < 5; ++k) partial[k * runs + run] = sum[k];
}

// x = Σ times_k answer_k, r = b − Σ times_k image_k; partial = Σ r².
kernel void start_from_former(
    const int rows, const int runs, global const sum_vec* restrict times,
    global const own* restrict inverse_diagonal, global const vec* restrict answer_0,
    global const vec* restrict answer_1, global const vec* restrict answer_2,
    global const vec* restrict answer_3, global const vec* restrict image_0,
    global const vec* restrict image_1, global const vec* restrict image_2,
    global const vec* restrict image_3, global const vec* restrict b, global vec* restrict x,
    global vec* restrict r, global vec* restrict y, global sum_vec* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  const vec t_0 = TO(REAL)(times[0]), t_1 = TO(REAL)(times[1]), t_2 = TO(REAL)(times[2]),
            t_3 = TO(REAL)(times[3]);
  for (int i = begin; i < end; i += step_over) {
    x[i] = t_0 * answer_0[i] + t_1 * answer_1[i] + t_2 * answer_2[i] + t_3 * answer_3[i];
    const vec left = b[i] - (t_0 * image_0[i] + t_1 * image_1[i] + t_2 * image_2[i] +
                             t_3 * image_3[i]);
    r[i] = left;
    y[i] = SMOOTHED(left);
    sum += TO(SUM)(left * left);
  }
  partial[run] = sum;
}

// out = a − b.
kernel void difference(const int rows, global const vec* restrict a, global const vec* restrict b,
                       global vec* restrict out) {
  ITEM(rows)
  out[i] = a[i] - b[i];
}
