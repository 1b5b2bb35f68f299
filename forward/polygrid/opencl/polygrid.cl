// Conjugate gradients on sparse rows, and a V-cycle on the aggregates of a graph with one step of
// Jacobi before and after. Sums run in a fixed order and are added up in SUM.
//
// Fields, and numbers of media of their own, are [row][lane] without gaps: at three lanes a fourth
// place would be a third more memory.

#ifndef SUM
#define SUM double
#endif

typedef LANES_OF(SUM) sum_vec;

// The lanes of row i.
#if WIDTH == 3
#define LOAD(i, field) vload3(i, field)
#define STORE(lanes, i, field) vstore3(lanes, i, field)
#else
#define LOAD(i, field) (((global const vec*)(field))[i])
#define STORE(lanes, i, field) ((global vec*)(field))[i] = (lanes)
#endif
#if OWN
#define NUMBER(i, numbers) LOAD(i, numbers)
#define SET_NUMBER(number, i, numbers) STORE(number, i, numbers)
#else
#define NUMBER(i, numbers) (numbers)[i]
#define SET_NUMBER(number, i, numbers) (numbers)[i] = (number)
#endif

// Rows beside each other are taken as blocks, their numbers as PARTS vectors of PART. Fields go on
// with zeros to the end of the last block.
#if INTERLEAVED
#define PART WIDTH
#define BLOCK 1
#else
#define PART 16
#if WIDTH == 1 || WIDTH == 3
#define BLOCK 16
#elif WIDTH == 2
#define BLOCK 8
#elif WIDTH == 4
#define BLOCK 4
#elif WIDTH == 8
#define BLOCK 2
#else
#define BLOCK 1
#endif
#endif
#define PARTS (BLOCK * WIDTH / PART)
#define BLOCKS_OF(rows) (((rows)-1) / BLOCK + 1)
#if PART == 1
typedef REAL part;
typedef SUM sum_part;
#define TO_PART(type) JOIN(convert_, type)
#define LOAD_PART(k, from) (from)[k]
#define STORE_PART(numbers, k, to) (to)[k] = (numbers)
#else
typedef JOIN(REAL, PART) part;
typedef JOIN(SUM, PART) sum_part;
#define TO_PART(type) JOIN(convert_, JOIN(type, PART))
#define LOAD_PART(k, from) JOIN(vload, PART)(k, from)
#define STORE_PART(numbers, k, to) JOIN(vstore, PART)(numbers, k, to)
#endif
#if INTERLEAVED
#define AT(k, field) LOAD(k, field)
#define SET(numbers, k, field) STORE(numbers, k, field)
#else
#define AT(k, field) LOAD_PART(k, field)
#define SET(numbers, k, field) STORE_PART(numbers, k, field)
#endif
#define FOR_PARTS(c) for (int c = 0; c < PARTS; ++c)

// Numbers of lanes as a block's.
inline void lanes_to_parts(global const SUM* of_lane, part* to) {
  REAL all[PART * PARTS];
  for (int k = 0; k < PART * PARTS; ++k) all[k] = (REAL)of_lane[k % WIDTH];
  FOR_PARTS(c) to[c] = LOAD_PART(c, all);
}

// partial[at] = Σ by lane of a block's sums, and of single rows'.
inline void leave_sum(const sum_part* of_block, const sum_vec of_rows, const int at,
                      global SUM* restrict partial) {
  SUM all[PART * PARTS];
  FOR_PARTS(c) STORE_PART(of_block[c], c, all);
  for (int k = WIDTH; k < PART * PARTS; ++k) all[k % WIDTH] += all[k];
#if WIDTH == 1
  partial[at] = all[0] + of_rows;
#else
  JOIN(vstore, WIDTH)(JOIN(vload, WIDTH)(0, all) + of_rows, at, partial);
#endif
}

// Jacobi's, before and after the coarse correction: of 1, 2 and 3 steps of Chebyshev's polynomial of
// the fourth kind on [0, 2] (Lottes 2023) the first takes the least work.
#define STEP ((REAL)2 / 3)

// Three lanes are multiplied as four, the next row's first among them.
#if WIDTH == 3
typedef JOIN(REAL, 4) row_vec;
#define ROW_LANES(field) vload4(0, field)
#define LANES_OF_ROW(lanes) (lanes).xyz
#else
typedef vec row_vec;
#define ROW_LANES(field) LOAD(0, field)
#define LANES_OF_ROW(lanes) (lanes)
#endif
#if OWN
#define NUMBER_WIDTH WIDTH
#define ROW_NUMBER(numbers) ROW_LANES(numbers)
#else
#define NUMBER_WIDTH 1
#define ROW_NUMBER(numbers) (numbers)[0]
#endif
#define ROW(i, field) ((field) + (long)WIDTH * (i))
#define ROW_NUMBERS(i, numbers) ((numbers) + (long)NUMBER_WIDTH * (i))

// Row i of a symmetric matrix of which half is stored, times x (device_numbers.h, DevicePattern).
inline vec row_product(const int i, global const int* restrict list,
                       global const int2* restrict step, global const REAL* restrict value,
                       global const REAL* restrict x) {
  const int place = list[i], end = place + step[place].x;
  global const REAL *numbers = ROW_NUMBERS(i, value), *factors = ROW(i, x);
#define PRODUCT(k) ROW_NUMBER(ROW_NUMBERS(step[k].y, numbers)) * ROW_LANES(ROW(step[k].x, factors))
  // Two sums: in one, additions wait for each other.
  row_vec sum = (row_vec)(0), other = (row_vec)(0);
  int k = place + 1;
  for (; k < end; k += 2) {
    sum += PRODUCT(k);
    other += PRODUCT(k + 1);
  }
  if (k == end) sum += PRODUCT(k);
  return LANES_OF_ROW(sum + other);
}

// The same for a block of rows that share a list, whose numbers are beside each other, too.
#define BLOCKS (!INTERLEAVED && (OWN || WIDTH == 1) && BLOCK > 1)
#if BLOCKS
inline int begins_block(const int i, const int end, global const int* restrict list) {
  return i + BLOCK <= end && all(JOIN(vload, BLOCK)(0, list + i) == (JOIN(int, BLOCK))(list[i]));
}

inline void block_product(const int i, global const int* restrict list,
                          global const int2* restrict step, global const REAL* restrict value,
                          global const REAL* restrict x, part* product) {
  const int place = list[i], end = place + step[place].x;
  part sum[PARTS];
  FOR_PARTS(c) sum[c] = (part)(0);
  for (int k = place + 1; k <= end; ++k) {
    global const REAL *numbers = ROW(i + step[k].y, value), *factors = ROW(i + step[k].x, x);
    FOR_PARTS(c) sum[c] += AT(c, numbers) * AT(c, factors);
  }
  FOR_PARTS(c) product[c] = sum[c];
}
#endif

// The same for some rows from i on, as many as share a list and fit into a vector of 16; returns
// how many.
#if WIDTH == 1
#define LOAD_PRIVATE(k, from) (from)[k]
#define STORE_PRIVATE(lanes, to) (to)[0] = (lanes)
#else
#define LOAD_PRIVATE(k, from) JOIN(vload, WIDTH)(k, from)
#define STORE_PRIVATE(lanes, to) JOIN(vstore, WIDTH)(lanes, 0, to)
#endif
inline int rows_product(const int i, const int end, global const int* restrict list,
                        global const int2* restrict step, global const REAL* restrict value,
                        global const REAL* restrict x, REAL* product) {
#if BLOCKS && WIDTH == 3
  const int place = list[i], last = place + step[place].x;
  int rows = 1;
  while (rows < 16 / WIDTH && i + rows < end && list[i + rows] == place) ++rows;
  if (rows > 1) {
    global const REAL *numbers = ROW(i, value), *factors = ROW(i, x);
    part sum = (part)(0);
    for (int k = place + 1; k <= last; ++k) {
      sum += AT(0, ROW(step[k].y, numbers)) * AT(0, ROW(step[k].x, factors));
    }
    STORE_PART(sum, 0, product);
    return rows;
  }
#endif
  STORE_PRIVATE(row_product(i, list, step, value, x), product);
  return 1;
}

// What the host has written, [row][slot], to its places, [slot][row].
kernel void take_rows(const int fresh_rows, const int rows, const int slots,
                      global const int* restrict fresh_row, global const REAL* restrict fresh,
                      global REAL* restrict value) {
  ITEM(fresh_rows)
  for (int k = 0; k < slots; ++k) {
    SET_NUMBER(NUMBER(i * slots + k, fresh), k * rows + fresh_row[i], value);
  }
}

kernel void take_lanes(const int fresh_rows, global const int* restrict fresh_row,
                       global const REAL* restrict fresh, global REAL* restrict field) {
  ITEM(fresh_rows)
  STORE(LOAD(i, fresh), fresh_row[i], field);
}

// Jacobi's step from zero: y = step r/d. On every level it is kept beside r.
#define SMOOTHED(r, inverse_diagonal) (STEP * (inverse_diagonal) * (r))

// r = b − A x.
kernel void residual(const int rows, global const int* restrict list,
                     global const int2* restrict step, global const REAL* restrict value,
                     global const REAL* restrict inverse_diagonal, global const REAL* restrict b,
                     global const REAL* restrict x, global REAL* restrict r,
                     global REAL* restrict y) {
  ITEM(rows)
  const vec left = LOAD(i, b) - row_product(i, list, step, value, x);
  STORE(left, i, r);
  STORE(SMOOTHED(left, LOAD(i, inverse_diagonal)), i, y);
}

// out = A x; partial = Σ x·out.
kernel void product(const int rows, const int runs, global const int* restrict list,
                    global const int2* restrict step, global const REAL* restrict value,
                    global const REAL* restrict x, global REAL* restrict out,
                    global SUM* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  sum_part of_blocks[PARTS];
  FOR_PARTS(c) of_blocks[c] = (sum_part)(0);
  for (int i = begin; i < end; i += step_over) {
#if BLOCKS
    if (begins_block(i, end, list)) {
      part image[PARTS];
      block_product(i, list, step, value, x, image);
      FOR_PARTS(c) {
        SET(image[c], c, ROW(i, out));
        of_blocks[c] += TO_PART(SUM)(AT(c, ROW(i, x)) * image[c]);
      }
      i += BLOCK - 1;
      continue;
    }
#endif
    REAL images[16];
    const int here = rows_product(i, end, list, step, value, x, images);
    for (int row = 0; row < here; ++row) {
      const vec image = LOAD_PRIVATE(row, images);
      STORE(image, i + row, out);
      sum += TO(SUM)(LOAD(i + row, x) * image);
    }
    i += here - 1;
  }
  leave_sum(of_blocks, sum, run, partial);
}

// What Jacobi's step leaves of the residual: r − (d y − Σ w y_n) = (1 − step) r + Σ w y_n.
kernel void left_of_residual(const int rows, const int runs, global const int* restrict list,
                             global const int2* restrict step, global const REAL* restrict link,
                             global const REAL* restrict r, global const REAL* restrict y,
                             global REAL* restrict left) {
  RUN(rows)
  for (int i = begin; i < end; i += step_over) {
#if BLOCKS
    if (begins_block(i, end, list)) {
      part inflow[PARTS];
      block_product(i, list, step, link, y, inflow);
      FOR_PARTS(c) SET(((REAL)1 - STEP) * AT(c, ROW(i, r)) + inflow[c], c, ROW(i, left));
      i += BLOCK - 1;
      continue;
    }
#endif
    REAL inflows[16];
    const int here = rows_product(i, end, list, step, link, y, inflows);
    for (int row = 0; row < here; ++row) {
      STORE(((REAL)1 - STEP) * LOAD(i + row, r) + LOAD_PRIVATE(row, inflows), i + row, left);
    }
    i += here - 1;
  }
}

// Down the V-cycle: coarse r = Σ over an aggregate's nodes of what is left.
kernel void down(const int aggregates, global const int* restrict first_child,
                 global const int* restrict child, global const REAL* restrict left,
                 global const REAL* restrict inverse_diagonal, global REAL* restrict coarse_r,
                 global REAL* restrict coarse_y) {
  ITEM(aggregates)
  vec sum = (vec)(0);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) sum += LOAD(child[c], left);
  STORE(sum, i, coarse_r);
  STORE(SMOOTHED(sum, LOAD(i, inverse_diagonal)), i, coarse_y);
}

// Up again, y with the coarser level's correction: x = y + step (r − A y)/d.
inline vec after_correction(const int i, const vec inflow,
                            global const REAL* restrict inverse_diagonal,
                            global const REAL* restrict r, global const REAL* restrict y) {
  const vec y_i = LOAD(i, y);
  return y_i + STEP * (LOAD(i, inverse_diagonal) * (LOAD(i, r) + inflow) - y_i);
}

// On the finest level; partial = Σ r·x.
kernel void up(const int rows, const int runs, global const int* restrict list,
               global const int2* restrict step, global const REAL* restrict link,
               global const REAL* restrict inverse_diagonal, global const REAL* restrict r,
               global const REAL* restrict y, global REAL* restrict x,
               global SUM* restrict partial) {
  RUN(rows)
  sum_vec sum = (sum_vec)(0);
  sum_part of_blocks[PARTS];
  FOR_PARTS(c) of_blocks[c] = (sum_part)(0);
  for (int i = begin; i < end; i += step_over) {
#if BLOCKS
    if (begins_block(i, end, list)) {
      part inflow[PARTS];
      block_product(i, list, step, link, y, inflow);
      FOR_PARTS(c) {
        const part y_i = AT(c, ROW(i, y)), r_i = AT(c, ROW(i, r));
        const part z = y_i + STEP * (AT(c, ROW(i, inverse_diagonal)) * (r_i + inflow[c]) - y_i);
        SET(z, c, ROW(i, x));
        of_blocks[c] += TO_PART(SUM)(r_i * z);
      }
      i += BLOCK - 1;
      continue;
    }
#endif
    REAL inflows[16];
    const int here = rows_product(i, end, list, step, link, y, inflows);
    for (int row = 0; row < here; ++row) {
      const vec z =
          after_correction(i + row, LOAD_PRIVATE(row, inflows), inverse_diagonal, r, y);
      STORE(z, i + row, x);
      sum += TO(SUM)(LOAD(i + row, r) * z);
    }
    i += here - 1;
  }
  leave_sum(of_blocks, sum, run, partial);
}

// On a coarser level: x corrects the finer level's nodes.
kernel void up_to_children(const int rows, global const int* restrict list,
                           global const int2* restrict step, global const REAL* restrict link,
                           global const REAL* restrict inverse_diagonal,
                           global const REAL* restrict r, global const REAL* restrict y,
                           global const int* restrict first_child,
                           global const int* restrict child, global REAL* restrict fine_y) {
  ITEM(rows)
  const vec inflow = row_product(i, list, step, link, y);
  const vec x = after_correction(i, inflow, inverse_diagonal, r, y);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) {
    STORE(LOAD(child[c], fine_y) + x, child[c], fine_y);
  }
}

// x = A⁻¹ r on the coarsest level.
inline vec direct(const int i, const int rows, global const REAL* restrict inverse,
                  global const REAL* restrict r) {
  vec sum = (vec)(0);
  for (int k = 0; k < rows; ++k) sum += NUMBER(k * rows + i, inverse) * LOAD(k, r);
  return sum;
}

kernel void solve_directly(const int rows, global const REAL* restrict inverse,
                           global const REAL* restrict r, global REAL* restrict x) {
  ITEM(rows)
  STORE(direct(i, rows, inverse, r), i, x);
}

kernel void direct_to_children(const int rows, global const REAL* restrict inverse,
                               global const REAL* restrict r,
                               global const int* restrict first_child,
                               global const int* restrict child, global REAL* restrict fine_y) {
  ITEM(rows)
  const vec x = direct(i, rows, inverse, r);
  for (int c = first_child[i]; c < first_child[i + 1]; ++c) {
    STORE(LOAD(child[c], fine_y) + x, child[c], fine_y);
  }
}

// Number by number, over all blocks of `rows`.
#define FOR_BLOCK_PARTS(k)                         \
  for (int block = begin; block < end; block += step_over) \
    for (int c = 0, k = block * PARTS; c < PARTS; ++c, ++k)

kernel void dot_product(const int rows, const int runs, global const REAL* restrict a,
                        global const REAL* restrict b, global SUM* restrict partial) {
  RUN(BLOCKS_OF(rows))
  sum_part sum[PARTS];
  FOR_PARTS(c) sum[c] = (sum_part)(0);
  FOR_BLOCK_PARTS(k) sum[c] += TO_PART(SUM)(AT(k, a) * AT(k, b));
  leave_sum(sum, (sum_vec)(0), run, partial);
}

// p = z + along p.
kernel void update_direction(const int rows, const int runs, global const SUM* restrict along,
                             global const REAL* restrict z, global REAL* restrict p) {
  RUN(BLOCKS_OF(rows))
  part times[PARTS];
  lanes_to_parts(along, times);
  FOR_BLOCK_PARTS(k) SET(AT(k, z) + times[c] * AT(k, p), k, p);
}

// x += step p, r −= step q; partial = Σ b·x.
kernel void update_solution(const int rows, const int runs, global const SUM* restrict step,
                            global const REAL* restrict inverse_diagonal,
                            global const REAL* restrict p, global const REAL* restrict q,
                            global const REAL* restrict b, global REAL* restrict x, global REAL* restrict r,
                            global REAL* restrict y, global SUM* restrict partial) {
  RUN(BLOCKS_OF(rows))
  part by[PARTS];
  lanes_to_parts(step, by);
  sum_part sum[PARTS];
  FOR_PARTS(c) sum[c] = (sum_part)(0);
  FOR_BLOCK_PARTS(k) {
    const part moved = AT(k, x) + by[c] * AT(k, p);
    SET(moved, k, x);
    const part left = AT(k, r) - by[c] * AT(k, q);
    SET(left, k, r);
    SET(SMOOTHED(left, AT(k, inverse_diagonal)), k, y);
    sum[c] += TO_PART(SUM)(AT(k, b) * moved);
  }
  leave_sum(sum, (sum_vec)(0), run, partial);
}

// Products of b with four images of former answers.
kernel void products_with_images(const int rows, const int runs, global const REAL* restrict b,
                                 global const REAL* restrict image_0,
                                 global const REAL* restrict image_1,
                                 global const REAL* restrict image_2,
                                 global const REAL* restrict image_3,
                                 global SUM* restrict partial) {
  RUN(BLOCKS_OF(rows))
  sum_part sum[4][PARTS];
  for (int kind = 0; kind < 4; ++kind) FOR_PARTS(c) sum[kind][c] = (sum_part)(0);
  FOR_BLOCK_PARTS(k) {
    const part mine = AT(k, b);
    sum[0][c] += TO_PART(SUM)(mine * AT(k, image_0));
    sum[1][c] += TO_PART(SUM)(mine * AT(k, image_1));
    sum[2][c] += TO_PART(SUM)(mine * AT(k, image_2));
    sum[3][c] += TO_PART(SUM)(mine * AT(k, image_3));
  }
  for (int kind = 0; kind < 4; ++kind) {
    leave_sum(sum[kind], (sum_vec)(0), kind * runs + run, partial);
  }
}

// x = Σ times_k answer_k, r = b − Σ times_k image_k; partial = Σ b·x.
kernel void start_from_former(
    const int rows, const int runs, global const SUM* restrict times,
    global const REAL* restrict inverse_diagonal, global const REAL* restrict answer_0,
    global const REAL* restrict answer_1, global const REAL* restrict answer_2,
    global const REAL* restrict answer_3, global const REAL* restrict image_0,
    global const REAL* restrict image_1, global const REAL* restrict image_2,
    global const REAL* restrict image_3, global const REAL* restrict b, global REAL* restrict x,
    global REAL* restrict r, global REAL* restrict y, global SUM* restrict partial) {
  RUN(BLOCKS_OF(rows))
  part t[4][PARTS];
  for (int former = 0; former < 4; ++former) lanes_to_parts(times + former * WIDTH, t[former]);
  sum_part sum[PARTS];
  FOR_PARTS(c) sum[c] = (sum_part)(0);
  FOR_BLOCK_PARTS(k) {
    const part start = t[0][c] * AT(k, answer_0) + t[1][c] * AT(k, answer_1) +
                       t[2][c] * AT(k, answer_2) + t[3][c] * AT(k, answer_3);
    SET(start, k, x);
    const part left = AT(k, b) - (t[0][c] * AT(k, image_0) + t[1][c] * AT(k, image_1) +
                                  t[2][c] * AT(k, image_2) + t[3][c] * AT(k, image_3));
    SET(left, k, r);
    SET(SMOOTHED(left, AT(k, inverse_diagonal)), k, y);
    sum[c] += TO_PART(SUM)(AT(k, b) * start);
  }
  leave_sum(sum, (sum_vec)(0), run, partial);
}

// image = b − r, its products with itself and with four others.
kernel void image_of_answer(const int rows, const int runs, global const REAL* restrict b,
                            global const REAL* restrict r, global const REAL* restrict other_0,
                            global const REAL* restrict other_1,
                            global const REAL* restrict other_2,
                            global const REAL* restrict other_3, global REAL* restrict image,
                            global SUM* restrict partial) {
  RUN(BLOCKS_OF(rows))
  sum_part sum[5][PARTS];
  for (int kind = 0; kind < 5; ++kind) FOR_PARTS(c) sum[kind][c] = (sum_part)(0);
  FOR_BLOCK_PARTS(k) {
    const part mine = AT(k, b) - AT(k, r);
    SET(mine, k, image);
    sum[0][c] += TO_PART(SUM)(mine * mine);
    sum[1][c] += TO_PART(SUM)(mine * AT(k, other_0));
    sum[2][c] += TO_PART(SUM)(mine * AT(k, other_1));
    sum[3][c] += TO_PART(SUM)(mine * AT(k, other_2));
    sum[4][c] += TO_PART(SUM)(mine * AT(k, other_3));
  }
  for (int kind = 0; kind < 5; ++kind) {
    leave_sum(sum[kind], (sum_vec)(0), kind * runs + run, partial);
  }
}
