// A V-cycle on the aggregates of a graph with one step of Jacobi before and after.

// Jacobi's, before and after the coarse correction: of 1, 2 and 3 steps of Chebyshev's polynomial of
// the fourth kind on [0, 2] (Lottes 2023) the first takes the least work.
#define STEP ((REAL)2 / 3)

// Jacobi's step from zero: y = step r/d. On every level it is kept beside r.
#define SMOOTHED(r, inverse_diagonal) (STEP * (inverse_diagonal) * (r))

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
