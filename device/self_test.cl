// Known-answer kernels: small integers in float, so that every correct device gives the same bits.
// Work-groups of GROUP items, one-dimensional.
#ifndef GROUP
#define GROUP 64  // items of a work-group
#endif

// y = a x + y
kernel void axpy(const int n, const float a, global const float* x, global float* y) {
  const int i = (int)get_global_id(0);
  if (i < n) y[i] += a * x[i];
}

// partial[group] = Σ x over the group, as a tree in local memory.
kernel void reduce(const int n, global const float* x, global float* partial) {
  local float tree[GROUP];
  const int l = (int)get_local_id(0), i = (int)get_global_id(0);
  tree[l] = i < n ? x[i] : 0.0f;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int half_size = GROUP / 2; half_size > 0; half_size /= 2) {
    if (l < half_size) tree[l] += tree[l + half_size];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (l == 0) partial[get_group_id(0)] = tree[0];
}

// sum[i] = x[first of the group] + ... + x[i] (Hillis & Steele 1986).
kernel void prefix(const int n, global const float* x, global float* sum) {
  local float scan[GROUP];
  const int l = (int)get_local_id(0), i = (int)get_global_id(0);
  scan[l] = i < n ? x[i] : 0.0f;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int reach = 1; reach < GROUP; reach *= 2) {
    const float before = l >= reach ? scan[l - reach] : 0.0f;
    barrier(CLK_LOCAL_MEM_FENCE);
    scan[l] += before;
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (i < n) sum[i] = scan[l];
}
