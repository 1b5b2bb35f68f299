// Conjugate gradients on sparse rows, and their start from former answers.

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

// p = z + along p, along being the scalar at `place`.
kernel void update_direction(const int rows, const int runs, const int place,
                             global const SUM* restrict scalars,
                             global const REAL* restrict z, global REAL* restrict p) {
  RUN(BLOCKS_OF(rows))
  part times[PARTS];
  lanes_to_parts(scalars + place * WIDTH, times);
  FOR_BLOCK_PARTS(k) SET(AT(k, z) + times[c] * AT(k, p), k, p);
}

// x += step p, r −= step q; partial = Σ b·x.
kernel void update_solution(const int rows, const int runs, global const SUM* restrict scalars,
                            global const REAL* restrict inverse_diagonal,
                            global const REAL* restrict p, global const REAL* restrict q,
                            global const REAL* restrict b, global REAL* restrict x, global REAL* restrict r,
                            global REAL* restrict y, global SUM* restrict partial) {
  RUN(BLOCKS_OF(rows))
  part by[PARTS];
  lanes_to_parts(scalars + CG_STEP * WIDTH, by);
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
