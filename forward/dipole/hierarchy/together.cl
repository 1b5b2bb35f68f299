// The form of GPUs: a work-group takes one receiver, and its TOGETHER items share the receiver's
// lists. Most lists are short, but a leaf with triangles of two sides of a body, or with large ones
// beside a fine mesh, meets thousands of clusters, for which all other items would wait. What items
// find is put in order, and sums run in a fixed order, so that equal input gives equal bits.
#ifndef TOGETHER
#define TOGETHER 32  // MOMENTS to 32, the bits of a mask
#endif
#define MOST_WAITING (8 * TOGETHER)
#define WAITING_ROOM (MOST_WAITING + 2 * TOGETHER + MOST_LEVELS)

#define GROUP __attribute__((reqd_work_group_size(TOGETHER, 1, 1)))

// As meet(), by TOGETHER emitters at a time; those opened wait on a stack. Where many wait they are
// taken one by one, by which the stack grows by one a level at most. `found`: two times three masks,
// of the items whose emitters were linked, opened and left; a round writes three while the others
// are cleared.
int2 meet_together(const int k, const int first_leaf, const float opening, const float smooth,
                   const float decay, const float least_decay, const int2 candidates,
                   global const float4* restrict cluster, global const int* left, const int base,
                   const int2 at, const int2 room, global int* links, global int* leaves,
                   local int* waiting, local uint* found) {
  const int item = (int)get_local_id(0);
  const uint before = (1u << item) - 1u;
  const float4 here = cluster[k];
  const int end = candidates.x + candidates.y;
  int links_n = 0, leaves_n = 0, stack = 0, turn = 0;
  if (item < 6) found[item] = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int next = candidates.x; stack > 0 || next < end; turn = 3 - turn) {
    const int most = stack > MOST_WAITING ? 1 : TOGETHER;
    const int old = min(stack, most), fresh = min(end - next, most - old);
    int e = 0, meets = -1;
    if (item < old + fresh) {
      if (item < old) {
        e = waiting[stack - 1 - item];
      } else if (k > 0) {
        e = left[next + item - old];
      }
      const float4 there = cluster[e];
      meets = meeting(here.w, k >= first_leaf, there.w, e >= first_leaf, here.x - there.x,
                      here.y - there.y, here.z - there.z, opening, smooth, decay, least_decay);
      atomic_or(found + turn + meets, 1u << item);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    const uint linked = found[turn + LINKED], opened = found[turn + EMITTER_OPENS],
               kept = found[turn + RECEIVER_OPENS];
    stack -= old;
    next += fresh;
    if (meets == LINKED) {
      const int place = links_n + (int)popcount(linked & before);
      if (place < room.x) links[at.x + place] = e;
    } else if (meets == RECEIVER_OPENS) {
      const int place = leaves_n + (int)popcount(kept & before);
      if (place < room.y) leaves[at.y + place] = e - base;
    } else if (meets == EMITTER_OPENS) {
      const int place = stack + 2 * (int)popcount(opened & before);
      waiting[place] = 2 * e + 1;
      waiting[place + 1] = 2 * e + 2;
    }
    links_n += (int)popcount(linked);
    leaves_n += (int)popcount(kept);
    stack += 2 * (int)popcount(opened);
    if (item < 3) found[3 - turn + item] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  return (int2)(links_n, leaves_n);
}

// As link_level(): lists are counted, then take what they need.
kernel GROUP void link_level_together(
    const int count, const int first_leaf, const float opening, const float smooth,
    const float decay, const float least_decay, const int links_capacity, const int near_capacity,
    const int left_capacity, global const float4* restrict cluster, global int2* left_range,
    global int* left, global int2* restrict cluster_range, global int* restrict emitter,
    global int2* restrict leaf_range, global int* restrict near, global int* restrict used) {
  local int waiting[WAITING_ROOM];
  local uint found[6];
  local int2 taken;
  const int i = (int)get_group_id(0), k = count - 1 + i;
  const int leaf = count - 1 == first_leaf, base = leaf ? first_leaf : 0;
  global int* leaves = leaf ? near : left;
  const int2 candidates = k > 0 ? left_range[(k - 1) / 2] : (int2)(0, 1);
  const int2 n = meet_together(k, first_leaf, opening, smooth, decay, least_decay, candidates,
                               cluster, left, base, (int2)(0), (int2)(0), emitter, leaves, waiting,
                               found);
  if (get_local_id(0) == 0) {
    int2 at = (int2)(0);
    if (n.x > 0) at.x = take(used, n.x, links_capacity);
    if (n.y > 0)
      at.y = leaf ? take(used + 1, n.y, near_capacity) : take(used + 2, n.y, left_capacity);
    const int fits = at.x >= 0 && at.y >= 0;
    taken = at;
    cluster_range[k] = fits ? (int2)(at.x, n.x) : (int2)(0);
    const int2 below = fits ? (int2)(at.y, n.y) : (int2)(0);
    if (leaf) {
      leaf_range[i] = below;
    } else {
      left_range[k] = below;
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (taken.x < 0 || taken.y < 0) return;
  meet_together(k, first_leaf, opening, smooth, decay, least_decay, candidates, cluster, left, base,
                taken, n, emitter, leaves, waiting, found);
}

// As push().
kernel GROUP void push_together(const int count, const float smooth2,
                                global const float4* restrict table,
                                global const int2* restrict range,
                                global const int* restrict emitter,
                                global const float4* restrict cluster,
                                global const float4* restrict moments,
                                global float4* restrict series) {
  local float4 part[TOGETHER][MOMENTS];
  const int item = (int)get_local_id(0);
  const int k = count - 1 + (int)get_group_id(0), parent = (k - 1) / 2;
  const int parts = clamp(range[k].y, 1, TOGETHER);
  float4 m[MOMENTS];
  for (int q = 0; q < MOMENTS; ++q) m[q] = (float4)(0.0f);
  if (item == 0 && k > 0) {
    float4 s[MOMENTS];
    for (int q = 0; q < MOMENTS; ++q) s[q] = series[MOMENTS * parent + q];
    moved(s, cluster[k] - cluster[parent], m);
  }
  add_links(k, item, TOGETHER, smooth2, table, range, emitter, cluster, moments, m);
  for (int q = 0; q < MOMENTS; ++q) part[item][q] = m[q];
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item < MOMENTS) {
    float4 sum = part[0][item];
    for (int p = 1; p < parts; ++p) sum += part[p][item];
    series[MOMENTS * k + item] = sum;
  }
}

// As evaluate(), of the `count` leaves.
kernel GROUP void evaluate_together(
    const int count, const float smooth2, const float smooth, const float opening,
    const float decay, global const float4* restrict table, global const int* restrict first,
    global const int2* restrict range, global const int* restrict near,
    global const int* restrict order, global const float4* restrict point,
    global const float4* restrict spread, global const float4* restrict corner,
    global const float4* restrict cluster, global const float4* restrict power,
    global const float4* restrict series, global float4* restrict exitance) {
  local float4 part[TOGETHER];
  const int item = (int)get_local_id(0), leaf = (int)get_group_id(0), k = count - 1 + leaf;
  const int parts = clamp(range[leaf].y, 1, TOGETHER);
  for (int p = first[leaf]; p < first[leaf + 1]; ++p) {
    float4 value = (float4)(0.0f);
    if (item == 0) {
      float4 s[MOMENTS];
      for (int q = 0; q < MOMENTS; ++q) s[q] = series[MOMENTS * k + q];
      value = of_series(s, point[p] - cluster[k]);
    }
    part[item] = with_near(value, p, range[leaf].x + item, range[leaf].x + range[leaf].y, TOGETHER,
                           smooth2, smooth, opening, decay, table, first, near, point, spread,
                           corner, power);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item == 0) {
      value = part[0];
      for (int q = 1; q < parts; ++q) value += part[q];
      exitance[order[p]] = value;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}
