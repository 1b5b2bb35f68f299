// The sums that runs have left are added up on the device: a GPU would else send some thousand numbers
// to the host in every iteration. In a fixed order, so that equal input gives equal bits.

#ifndef SUM
#define SUM double
#endif
#define WORKGROUP 256

typedef LANES_OF(SUM) sum_vec;

// sum[kind] = Σ partial[kind][run], by one work-group each.
kernel __attribute__((reqd_work_group_size(WORKGROUP, 1, 1))) void add_runs(
    const int runs, global const sum_vec* restrict partial, global sum_vec* restrict sum) {
  local sum_vec scratch[WORKGROUP];
  const int item = (int)get_local_id(0), kind = (int)get_group_id(0);
  sum_vec own_sum = (sum_vec)(0);
  for (int run = item; run < runs; run += WORKGROUP) own_sum += partial[kind * runs + run];
  scratch[item] = own_sum;
  for (int span = WORKGROUP / 2; span > 0; span /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < span) scratch[item] += scratch[item + span];
  }
  if (item == 0) sum[kind] = scratch[0];
}
