// The sums that runs have left are added up on the device, and what conjugate gradients take of them is
// computed there: no iteration waits for the host. In a fixed order, so that equal input gives equal
// bits.

#ifndef SUM
#define SUM double
#endif
#ifndef SCALED
#define SCALED 0  // 1: z belongs to the residual of length one
#endif
#define WORKGROUP 256

typedef LANES_OF(SUM) sum_vec;

// Lanes lie without gaps, also three of them.
#if WIDTH == 1
#define LANES_AT(k, sums) (sums)[k]
#define SET_LANES(lanes, k, sums) (sums)[k] = (lanes)
#else
#define LANES_AT(k, sums) JOIN(vload, WIDTH)(k, sums)
#define SET_LANES(lanes, k, sums) JOIN(vstore, WIDTH)(lanes, k, sums)
#endif

// a/b per lane, 0 where b is not positive.
sum_vec quotient(sum_vec a, sum_vec b) {
  const sum_vec safe = b > (sum_vec)(0) ? b : (sum_vec)(1);
  return b > (sum_vec)(0) ? a / safe : (sum_vec)(0);
}

// A sum at its place, and what follows of it.
void put(const sum_vec sum, const int place, global SUM* restrict scalars) {
  if (place == CG_R_Z) {
    const sum_vec before = LANES_AT(CG_R_Z, scalars);
    const sum_vec now = SCALED ? sum * LANES_AT(CG_LENGTH, scalars) : sum;
    SET_LANES(before, CG_BEFORE, scalars);
    SET_LANES(now, CG_R_Z, scalars);
    SET_LANES(quotient(now, before), CG_ALONG, scalars);
  } else if (place == CG_STEP) {
    SET_LANES(quotient(LANES_AT(CG_R_Z, scalars), sum), CG_STEP, scalars);
  } else {
    SET_LANES(sum, place, scalars);
  }
  if (place == CG_SIZE) {
    SET_LANES(sum > (sum_vec)(0) ? sqrt(sum) : (sum_vec)(1), CG_LENGTH, scalars);
  }
}

// scalars[place + kind] = Σ partial[kind][run], by one work-group each.
kernel __attribute__((reqd_work_group_size(WORKGROUP, 1, 1))) void add_runs(
    const int runs, const int place, global const SUM* restrict partial,
    global SUM* restrict scalars) {
  local sum_vec scratch[WORKGROUP];
  const int item = (int)get_local_id(0), kind = (int)get_group_id(0);
  sum_vec own_sum = (sum_vec)(0);
  for (int run = item; run < runs; run += WORKGROUP) own_sum += LANES_AT(kind * runs + run, partial);
  scratch[item] = own_sum;
  for (int span = WORKGROUP / 2; span > 0; span /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < span) scratch[item] += scratch[item + span];
  }
  if (item == 0) put(scratch[0], place + kind, scalars);
}
