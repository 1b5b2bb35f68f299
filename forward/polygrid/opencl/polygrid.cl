// Conjugate gradients on sparse rows, and a V-cycle on the aggregates of a graph with one step of
// Jacobi before and after. Every item writes its own row; sums run in a fixed order.
//
// SUM is what sums are added up in.

#ifndef SUM
#define SUM double
#endif

typedef LANES_OF(SUM) sum_vec;

// Row i of the matrix times x.
inline vec row_product(const int i, global const int* restrict start,
                       global const int* restrict column, global const own* restrict value,
                       global const vec* restrict x) {
  vec sum = (vec)(0);
  const int end = start[i + 1];
  for (int k = start[i]; k < end; ++k) sum += value[k] * x[column[k]];
  return sum;
}

// r = b − A x.
kernel void residual(const int rows, global const int* restrict start,
                     global const int* restrict column, global const own* restrict value,
                     global const vec* restrict b, global const vec* restrict x,
                     global vec* restrict r) {
  ITEM(rows)
  r[i] = b[i] - row_product(i, start, column, value, x);
}

// out = A x.
kernel void product(const int rows, global const int* restrict start,
                    global const int* restrict column, global const own* restrict value,
                    global const vec* restrict x, global vec* restrict out) {
  ITEM(rows)
  out[i] = row_product(i, start, column, value, x);
}

// Down the V-cycle: coarse r = Σ over an aggregate's nodes of the residual after one step of Jacobi
// from zero. With y = step r/d: r − (d y − Σ w y_n) = (1 − step) r + Σ w y_n.
kernel void down(const int aggregates, const REAL step, global const int* restrict first_child,
                 global const int* restrict child, global const int* restrict start,
                 global const int* restrict column, global const own* restrict link,
                 global const own* restrict inverse_diagonal, global const vec* restrict r,
                 global vec* restrict coarse_r) {
  ITEM(aggregates)
  vec sum = (vec)(0);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) {
    const int row = child[c];
    vec inflow = (vec)(0);
    for (int k = start[row]; k < start[row + 1]; ++k) {
      const int n = column[k];
      inflow += link[k] * (inverse_diagonal[n] * r[n]);
    }
    sum += ((REAL)1 - step) * r[row] + step * inflow;
  }
  coarse_r[i] = sum;
}

// Up again: y = step r/d + correction of the aggregate, x = y + step (r − A y)/d.
kernel void up(const int rows, const REAL step, global const int* restrict parent,
               global const int* restrict start, global const int* restrict column,
               global const own* restrict link, global const own* restrict inverse_diagonal,
               global const vec* restrict r, global const vec* restrict coarse_x,
               global vec* restrict x) {
  ITEM(rows)
  vec inflow = (vec)(0);
  for (int k = start[i]; k < start[i + 1]; ++k) {
    const int n = column[k];
    inflow += link[k] * (step * inverse_diagonal[n] * r[n] + coarse_x[parent[n]]);
  }
  const vec jacobi = inverse_diagonal[i] * r[i];
  const vec y = step * jacobi + coarse_x[parent[i]];
  x[i] = y + step * (jacobi - y + inverse_diagonal[i] * inflow);
}

// x = A⁻¹ r on the coarsest level.
kernel void solve_directly(const int rows, global const own* restrict inverse,
                           global const vec* restrict r, global vec* restrict x) {
  ITEM(rows)
  vec sum = (vec)(0);
  for (int k = 0; k < rows; ++k) sum += inverse[(size_t)k * rows + i] * r[k];
  x[i] = sum;
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

// out += times x.
kernel void add(const int rows, global const sum_vec* restrict times, global const vec* restrict x,
                global vec* restrict out) {
  ITEM(rows)
  out[i] += TO(REAL)(times[0]) * x[i];
}

// x += step p, r −= step q; partial = Σ r².
kernel void update_solution(const int rows, const int runs, global const sum_vec* restrict step,
                            global const vec* restrict p, global const vec* restrict q,
                            global vec* restrict x, global vec* restrict r,
                            global sum_vec* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  const vec by = TO(REAL)(step[0]);
  for (int k = begin; k < end; k += step_over) {
    x[k] += by * p[k];
    const vec left = r[k] - by * q[k];
    r[k] = left;
    sum += TO(SUM)(left * left);
  }
  partial[run] = sum;
}
