// Links (links.h), level by level from the root down. A work-item takes some receivers one after the
// other. Each meets the emitters that its parent has left, and opens those that are larger; what it
// leaves its children meet. What a leaf leaves are the leaves near it. Lists lie in pools of links
// (x) and of what is left (y), in regions that items take. A GPU's form is in together.cl.
#ifndef MOST_LEVELS
#define MOST_LEVELS 30
#endif
#ifndef QUEUE
#define QUEUE 256  // opened emitters that wait, about
#endif

// The lengths of a receiver's lists, which are written from `at` on as far as there is `room`; what
// it leaves is numbered from `base`. Emitters wait in a queue, since one after the other does not
// depend on how the first is met. Where it is full it is a stack, which grows by one a level at
// most.
int2 meet(const int k, const int first_leaf, const float opening, const float smooth,
          const float decay, const float least_decay, const int2 candidates,
          global const float4* restrict cluster, global const int* left, const int base,
          const int2 at, const int2 room, global int* links, global int* leaves) {
  const float4 here = cluster[k];
  const int end = candidates.x + candidates.y;
  int waiting[QUEUE + MOST_LEVELS + 4];
  int links_n = 0, leaves_n = 0;
  for (int next = candidates.x; next < end;) {
    int first = 0, last = 0;
    while (first < last || (next < end && last < QUEUE / 2)) {
      int e = 0;
      if (next < end && last < QUEUE / 2) {
        if (k > 0) e = left[next];
        ++next;
      } else {
        if (last > QUEUE) waiting[--first] = waiting[--last];
        e = waiting[first++];
      }
      const float4 there = cluster[e];
      const int meets = meeting(here.w, k >= first_leaf, there.w, e >= first_leaf, here.x - there.x,
                                here.y - there.y, here.z - there.z, opening, smooth, decay,
                                least_decay);
      // Written wherever it may be the next of a list, which a processor need not decide first.
      if (links_n < room.x) links[at.x + links_n] = e;
      if (leaves_n < room.y) leaves[at.y + leaves_n] = e - base;
      links_n += meets == LINKED;
      leaves_n += meets == RECEIVER_OPENS;
      waiting[last] = 2 * e + 1;
      waiting[last + 1] = 2 * e + 2;
      last += 2 * (meets == EMITTER_OPENS);
    }
  }
  return (int2)(links_n, leaves_n);
}

// Where a region of a pool begins; -1 where it does not fit, which leaves `used` above `capacity`.
int take(global int* used, const int length, const int capacity) {
  if (*(volatile global int*)used > capacity) return -1;
  const int at = atomic_add(used, length);
  return at >= 0 && at <= capacity - length ? at : -1;
}

// Links of the receivers of one level, [count - 1, 2 count - 1), `run` of them to an item, which
// takes regions of `region` places at least. `used`: places of the pools of links, near and left;
// then the links and the near leaves that there are.
kernel void link_level(const int count, const int run, const int region, const int first_leaf,
                       const float opening, const float smooth, const float decay,
                       const float least_decay, const int links_capacity, const int near_capacity,
                       const int left_capacity, global const float4* restrict cluster,
                       global int2* left_range, global int* left,
                       global int2* restrict cluster_range, global int* restrict emitter,
                       global int2* restrict leaf_range, global int* restrict near,
                       global int* restrict used) {
  const int begin = run * (int)get_global_id(0), end = min(begin + run, count);
  const int leaf = count - 1 == first_leaf, base = leaf ? first_leaf : 0;
  global int* leaves = leaf ? near : left;
  int2 at = (int2)(0), room = (int2)(0), sum = (int2)(0);
  for (int i = begin; i < end;) {
    const int k = count - 1 + i;
    const int2 candidates = k > 0 ? left_range[(k - 1) / 2] : (int2)(0, 1);
    int2 n = meet(k, first_leaf, opening, smooth, decay, least_decay, candidates, cluster, left,
                  base, at, room, emitter, leaves);
    if (n.x > room.x || n.y > room.y) {
      if (n.x > room.x) {
        room.x = max(n.x, region);
        at.x = take(used, room.x, links_capacity);
      }
      if (n.y > room.y) {
        room.y = max(n.y, region);
        at.y = leaf ? take(used + 1, room.y, near_capacity) : take(used + 2, room.y, left_capacity);
      }
      if (at.x >= 0 && at.y >= 0) continue;  // again, with room
      n = at = room = (int2)(0);
    }
    cluster_range[k] = (int2)(at.x, n.x);
    if (leaf) {
      leaf_range[i] = (int2)(at.y, n.y);
    } else {
      left_range[k] = (int2)(at.y, n.y);
    }
    at += n;
    room -= n;
    sum += n;
    ++i;
  }
  if (sum.x > 0) atomic_add(used + 3, sum.x);
  if (leaf && sum.y > 0) atomic_add(used + 4, sum.y);
}
