// Sums of what kernels leave: one number per lane and row or work-group, added in a fixed order, so
// that equal input gives equal bits.
#define WORKGROUP 256

// sum = Σ partial[k], [k][GROUPS], by one work-group.
kernel __attribute__((reqd_work_group_size(WORKGROUP, 1, 1))) void sum_partials(
    const int count, global const accu_vec* restrict partial, global accu_vec* restrict sum) {
  local accu_vec scratch[WORKGROUP];
  const int item = (int)get_local_id(0), group = item % GROUPS;
  accu_vec own = (accu_vec)(0);
  for (int k = item / GROUPS; k < count; k += WORKGROUP / GROUPS)
    own += partial[k * GROUPS + group];
  scratch[item] = own;
  for (int span = WORKGROUP / 2; span >= GROUPS; span /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < span) scratch[item] += scratch[item + span];
  }
  if (item < GROUPS) sum[item] = scratch[item];
}
