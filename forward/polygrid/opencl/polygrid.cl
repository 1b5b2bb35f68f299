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

// Row i of a symmetric matrix of which half is stored, times x (device_numbers.h, DevicePattern).
inline vec row_product(const int i, global const int* restrict list,
                       global const int2* restrict step, global const own* restrict value,
                       global const vec* restrict x) {
  const int place = list[i], end = place + step[place].x;
  // Two sums: in one, additions wait for each other.
  vec sum = (vec)(0), other = (vec)(0);
  int k = place + 1;
  for (; k < end; k += 2) {
    sum += value[i + step[k].y] * x[i + step[k].x];
    other += value[i + step[k + 1].y] * x[i + step[k + 1].x];
  }
  if (k == end) sum += value[i + step[k].y] * x[i + step[k].x];
  return sum + other;
}

// Rows beside each other that share a list, at once: their numbers are so, too.
#define BLOCK (16 / WIDTH)
#define BLOCKS (!INTERLEAVED && (OWN || WIDTH == 1) && BLOCK > 1)
typedef JOIN(REAL, 16) wide;
typedef JOIN(SUM, 16) wide_sum;
#if WIDTH == 1
#define LANES_AT(k, numbers) (numbers)[k]
#else
#define LANES_AT(k, numbers) JOIN(vload, WIDTH)(k, numbers)
#endif
#define WIDE(field, i) vload16(0, (global const REAL*)(field) + (size_t)WIDTH * (i))

inline int begins_block(const int i, const int end, global const int* restrict list) {
  int alike = i + BLOCK <= end;
  for (int k = 1; alike && k < BLOCK; ++k) alike = list[i + k] == list[i];
  return alike;
}

inline wide block_product(const int i, global const int* restrict list,
                          global const int2* restrict step, global const own* restrict value,
                          global const vec* restrict x) {
  const int place = list[i], end = place + step[place].x;
  wide sum = (wide)(0);
  for (int k = place + 1; k <= end; ++k) sum += WIDE(value, i + step[k].y) * WIDE(x, i + step[k].x);
  return sum;
}

// Σ over a block's rows.
inline sum_vec of_block(const wide_sum sum) {
  SUM part[16];
  vstore16(sum, 0, part);
  sum_vec result = (sum_vec)(0);
  for (int k = 0; k < BLOCK; ++k) result += LANES_AT(k, part);
  return result;
}

// Rows that the host has written, [row][slot], to their places, [slot][row].
kernel void take_rows(const int fresh_rows, const int rows, const int slots,
                      global const int* restrict fresh_row, global const own* restrict fresh,
                      global own* restrict value) {
  ITEM(fresh_rows)
  for (int k = 0; k < slots; ++k) value[k * rows + fresh_row[i]] = fresh[i * slots + k];
}

// Jacobi's step from zero: y = step r/d. On every level it is kept beside r.
#define SMOOTHED(r) (STEP * inverse_diagonal[i] * (r))

// r = b − A x.
kernel void residual(const int rows, global const int* restrict list,
                     global const int2* restrict step, global const own* restrict value,
                     global const own* restrict inverse_diagonal, global const vec* restrict b,
                     global const vec* restrict x, global vec* restrict r,
                     global vec* restrict y) {
  ITEM(rows)
  r[i] = b[i] - row_product(i, list, step, value, x);
  y[i] = SMOOTHED(r[i]);
}

// out = A x; partial = Σ x·out.
kernel void product(const int rows, const int runs, global const int* restrict list,
                    global const int2* restrict step, global const own* restrict value,
                    global const vec* restrict x, global vec* restrict out,
                    global sum_vec* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  wide_sum of_blocks = (wide_sum)(0);
  for (int i = begin; i < end; i += step_over) {
    if (BLOCKS && begins_block(i, end, list)) {
      const wide image = block_product(i, list, step, value, x);
      vstore16(image, 0, (global REAL*)(out + i));
      of_blocks += JOIN(convert_, JOIN(SUM, 16))(WIDE(x, i) * image);
      i += BLOCK - 1;
      continue;
    }
    const vec image = row_product(i, list, step, value, x);
    out[i] = image;
    sum += TO(SUM)(x[i] * image);
  }
  partial[run] = sum + of_block(of_blocks);
}

// Down the V-cycle: coarse r = Σ over an aggregate's nodes of the residual after Jacobi's step:
// r − (d y − Σ w y_n) = (1 − step) r + Σ w y_n.
kernel void down(const int aggregates, global const int* restrict first_child,
                 global const int* restrict child, global const int* restrict list,
                 global const int2* restrict step, global const own* restrict link,
                 global const vec* restrict r, global const vec* restrict y,
                 global const own* restrict inverse_diagonal, global vec* restrict coarse_r,
                 global vec* restrict coarse_y) {
  ITEM(aggregates)
  vec sum = (vec)(0);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) {
    const int node = child[c];
    sum += ((REAL)1 - STEP) * r[node] + row_product(node, list, step, link, y);
  }
  coarse_r[i] = sum;
  coarse_y[i] = SMOOTHED(sum);
}

// Up again, y with the coarser level's correction: x = y + step (r − A y)/d.
inline vec after_correction(const int i, global const int* restrict list,
                            global const int2* restrict step, global const own* restrict link,
                            global const own* restrict inverse_diagonal,
                            global const vec* restrict r, global const vec* restrict y) {
  const vec inflow = row_product(i, list, step, link, y);
  return y[i] + STEP * (inverse_diagonal[i] * (r[i] + inflow) - y[i]);
}

// On the finest level; partial = Σ r·x.
kernel void up(const int rows, const int runs, global const int* restrict list,
               global const int2* restrict step, global const own* restrict link,
               global const own* restrict inverse_diagonal, global const vec* restrict r,
               global const vec* restrict y, global vec* restrict x,
               global sum_vec* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  wide_sum of_blocks = (wide_sum)(0);
  for (int i = begin; i < end; i += step_over) {
    if (BLOCKS && begins_block(i, end, list)) {
      const wide inflow = block_product(i, list, step, link, y), y_i = WIDE(y, i), r_i = WIDE(r, i);
      const wide z = y_i + STEP * (WIDE(inverse_diagonal, i) * (r_i + inflow) - y_i);
      vstore16(z, 0, (global REAL*)(x + i));
      of_blocks += JOIN(convert_, JOIN(SUM, 16))(r_i * z);
      i += BLOCK - 1;
      continue;
    }
    const vec z = after_correction(i, list, step, link, inverse_diagonal, r, y);
    x[i] = z;
    sum += TO(SUM)(r[i] * z);
  }
  partial[run] = sum + of_block(of_blocks);
}

// On a coarser level: x corrects the finer level's nodes.
kernel void up_to_children(const int rows, global const int* restrict list,
                           global const int2* restrict step, global const own* restrict link,
                           global const own* restrict inverse_diagonal,
                           global const vec* restrict r, global const vec* restrict y,
                           global const int* restrict first_child,
                           global const int* restrict child, global vec* restrict fine_y) {
  ITEM(rows)
  const vec x = after_correction(i, list, step, link, inverse_diagonal, r, y);
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
