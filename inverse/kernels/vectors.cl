// The vectors of a fit in the memory of a device. All are double but the pairs of L-BFGS, which are
// float; pairs of fields are [2][z][y][x]. Sums and maxima are left by work-groups of GROUP items,
// each for SPAN elements, and finished by finish(): in a fixed order, so that equal input gives
// equal bits.
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#ifndef GROUP
#define GROUP 128
#endif
#define SPAN (16 * GROUP)

#define ELEMENT(count)               \
  const size_t i = get_global_id(0); \
  if (i >= (size_t)(count)) return;

// The elements of an item of a reduction.
#define FOR_ELEMENTS(i, count)                                                       \
  for (size_t i = get_group_id(0) * (size_t)SPAN + get_local_id(0),                  \
              last_##i = min((size_t)(count), (get_group_id(0) + 1) * (size_t)SPAN); \
       i < last_##i; i += GROUP)

#define REDUCTION kernel __attribute__((reqd_work_group_size(GROUP, 1, 1)))

// Leaves the group's sum, or largest value, of `own` in partial[kind][group].
void leave(const double own, const int maximum, const int kind, local double* scratch,
           global double* partial) {
  const int item = (int)get_local_id(0);
  barrier(CLK_LOCAL_MEM_FENCE);
  scratch[item] = own;
  for (int span = GROUP / 2; span > 0; span /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < span) {
      const double other = scratch[item + span];
      scratch[item] = maximum ? fmax(scratch[item], other) : scratch[item] + other;
    }
  }
  if (item == 0) partial[kind * get_num_groups(0) + get_group_id(0)] = scratch[0];
}

// The sum over groups of each kind, or of the first `maxima` kinds the largest, to result[first]
// and on; a group per kind.
REDUCTION void finish(const int groups, const int maxima, const int first,
                      global const double* restrict partial, global double* restrict result) {
  local double scratch[GROUP];
  const int kind = (int)get_group_id(0), maximum = kind < maxima;
  double own = 0;
  for (int g = (int)get_local_id(0); g < groups; g += GROUP) {
    const double other = partial[(size_t)kind * groups + g];
    own = maximum ? fmax(own, other) : own + other;
  }
  leave(own, maximum, 0, scratch, result + first);
}

// s·y, s·g, y_j·y and y_j·g of pair j with the newest change y and the gradient g.
REDUCTION void pair_products(const int count, global const float* restrict step,
                             global const float* restrict change, global const float* restrict y,
                             global const double* restrict g, global double* restrict partial) {
  local double scratch[GROUP];
  double sum[4] = {0, 0, 0, 0};
  FOR_ELEMENTS(i, count) {
    const double s = step[i], c = change[i];
    sum[0] += s * y[i];
    sum[1] += s * g[i];
    sum[2] += c * y[i];
    sum[3] += c * g[i];
  }
  for (int kind = 0; kind < 4; ++kind) leave(sum[kind], 0, kind, scratch, partial);
}

REDUCTION void square(const int count, global const float* restrict a,
                      global double* restrict partial) {
  local double scratch[GROUP];
  double sum = 0;
  FOR_ELEMENTS(i, count) sum += (double)a[i] * a[i];
  leave(sum, 0, 0, scratch, partial);
}

REDUCTION void dot_product(const int count, global const double* restrict a,
                           global const double* restrict b, global double* restrict partial) {
  local double scratch[GROUP];
  double sum = 0;
  FOR_ELEMENTS(i, count) sum += a[i] * b[i];
  leave(sum, 0, 0, scratch, partial);
}

REDUCTION void largest_difference(const int count, global const double* restrict a,
                                  global const double* restrict b,
                                  global double* restrict partial) {
  local double scratch[GROUP];
  double largest = 0;
  FOR_ELEMENTS(i, count) largest = fmax(largest, fabs(a[i] - b[i]));
  leave(largest, 1, 0, scratch, partial);
}

// The largest |log|, infinite where one is not finite, and the sums of log κ and of log μ.
REDUCTION void range_of(const int cells, global const double* restrict logs,
                        global double* restrict partial) {
  local double scratch[GROUP];
  double largest = 0, sum_kappa = 0, sum_mu = 0;
  FOR_ELEMENTS(i, cells) {
    const double k = logs[i], m = logs[i + cells];
    largest = isfinite(k) && isfinite(m) ? fmax(largest, fmax(fabs(k), fabs(m))) : INFINITY;
    sum_kappa += k;
    sum_mu += m;
  }
  leave(largest, 1, 0, scratch, partial);
  leave(sum_kappa, 0, 1, scratch, partial);
  leave(sum_mu, 0, 2, scratch, partial);
}

kernel void set_scaled(const int count, const double factor, global const double* restrict from,
                       global double* restrict to) {
  ELEMENT(count)
  to[i] = factor * from[i];
}

// to += factor · term.
kernel void add_scaled(const int count, const double factor, global const double* restrict term,
                       global double* restrict to) {
  ELEMENT(count)
  to[i] += factor * term[i];
}

// to += a step + b change.
kernel void add_pair(const int count, const double a, global const float* restrict step,
                     const double b, global const float* restrict change,
                     global double* restrict to) {
  ELEMENT(count)
  to[i] += a * step[i] + b * change[i];
}

// to = from + length · direction.
kernel void move_along(const int count, const double length, global const double* restrict from,
                       global const double* restrict direction, global double* restrict to) {
  ELEMENT(count)
  to[i] = from[i] + length * direction[i];
}

// to = a − b.
kernel void difference(const int count, global const double* restrict a,
                       global const double* restrict b, global float* restrict to) {
  ELEMENT(count)
  to[i] = (float)(a[i] - b[i]);
}

// A pair of L-BFGS to double and back.
kernel void widen(const int count, global const float* restrict from, global double* restrict to) {
  ELEMENT(count)
  to[i] = from[i];
}
kernel void narrow(const int count, global const double* restrict from, global float* restrict to) {
  ELEMENT(count)
  to[i] = (float)from[i];
}

// log μ from w = sinh(log μ/μ₀) (absorption_scale.h), in place.
kernel void log_of_scaled(const int cells, const double log_scale, global double* restrict fields) {
  ELEMENT(cells)
  fields[cells + i] = asinh(fields[cells + i]) + log_scale;
}
