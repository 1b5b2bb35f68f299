// Vectors of conjugate gradients on a batch: every pattern (lane) has its own scalars. Sums run in
// a fixed order: rows in parallel, then stripes of rows, then stripes, so that equal input gives
// equal bits. Vectors are [cell][GROUPS], scalars [GROUPS] of ACCU vectors.

#ifndef INTERLEAVED
#define INTERLEAVED 0  // 1: neighbouring items, neighbouring cells (GPUs); 0: own stretches
#endif

// One item per vector group and run of cells.
#define RUN_SETUP                                                                    \
  const int group = (int)get_global_id(0);                                           \
  const int run = (int)get_global_id(1);                                             \
  if (group >= GROUPS || run >= runs) return;                                        \
  const int length = (cells - 1) / runs + 1;                                         \
  const int begin = INTERLEAVED ? run : run * length, step = INTERLEAVED ? runs : 1; \
  const int end = INTERLEAVED ? cells : min(begin + length, cells);

// partial[run] = Σ a·b over the run's cells.
kernel void dot_runs(const int cells, const int runs, global const vec* restrict a,
                     global const vec* restrict b, global accu_vec* restrict partial) {
  RUN_SETUP
  accu_vec sum = (accu_vec)(0);
  for (int i = begin; i < end; i += step) {
    sum += to_accu(a[(size_t)i * GROUPS + group]) * to_accu(b[(size_t)i * GROUPS + group]);
  }
  partial[run * GROUPS + group] = sum;
}

// stripe[s] = Σ partial[k], k = s, s + stripes, ...; called again with one stripe for the total.
kernel void sum_stripes(const int count, const int stripes, global const accu_vec* restrict partial,
                        global accu_vec* restrict stripe) {
  const int group = (int)get_global_id(0);
  const int s = (int)get_global_id(1);
  if (group >= GROUPS || s >= stripes) return;
  accu_vec sum = (accu_vec)(0);
  for (int k = s; k < count; k += stripes) sum += partial[k * GROUPS + group];
  stripe[s * GROUPS + group] = sum;
}

// p = z + (rz / rz_before) p; the first time rz_before is 0, hence p = z.
kernel void update_direction(const int cells, const int runs, global const accu_vec* restrict rz,
                             global const accu_vec* restrict rz_before,
                             global const vec* restrict z, global vec* restrict p) {
  RUN_SETUP
  const vec beta = to_vec(ratio(rz[group], rz_before[group]));
  for (int i = begin; i < end; i += step) {
    const size_t k = (size_t)i * GROUPS + group;
    p[k] = z[k] + beta * p[k];
  }
}

// x += α p, r −= α q with α = rz / pq; partial[run] = Σ r².
kernel void update_solution(const int cells, const int runs, global const accu_vec* restrict rz,
                            global const accu_vec* restrict pq, global const vec* restrict p,
                            global const vec* restrict q, global vec* restrict x,
                            global vec* restrict r, global accu_vec* restrict partial) {
  RUN_SETUP
  const vec alpha = to_vec(ratio(rz[group], pq[group]));
  accu_vec sum = (accu_vec)(0);
  for (int i = begin; i < end; i += step) {
    const size_t k = (size_t)i * GROUPS + group;
    x[k] += alpha * p[k];
    const vec residual = r[k] - alpha * q[k];
    r[k] = residual;
    sum += to_accu(residual) * to_accu(residual);
  }
  partial[run * GROUPS + group] = sum;
}

// x + d anew, as the nearest x and what that leaves over (Knuth's two-sum).
kernel void renormalise(const int cells, const int runs, global vec* restrict x,
                        global vec* restrict d) {
  RUN_SETUP
  for (int i = begin; i < end; i += step) {
    const size_t k = (size_t)i * GROUPS + group;
    const vec high = x[k] + d[k], shift = high - x[k];
    d[k] = (x[k] - (high - shift)) + (d[k] - shift);
    x[k] = high;
  }
}
