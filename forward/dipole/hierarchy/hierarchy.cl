// Exitance of clusters of triangles under four irradiances at once, each with a profile of its own:
// a vector's lanes are colour channels or lights.
//
// Clusters are a complete binary tree, children of k: 2k + 1 and 2k + 2. A cluster's moments about
// its centre, and its share of the exitance as a Taylor series about it, are MOMENTS = 10 vectors:
//
//   0: Σ p or value    1-3: Σ p δ or gradient    4-9: Σ p δδᵀ or Hessian (xx, yy, zz, xy, xz, yz)
//
// p = irradiance · area, δ from the centre; both series end with the second order. One work-item
// per cluster, or per subtree of `levels` levels below its root, whose moments and series then stay
// in a processor's cache; items past `count` return. Lengths in mm.
//
// Profiles are a table over u = r² + SMOOTH2 (SMOOTH2 a power of two): 4 vectors per entry, R_d,
// R'/r, (R'/r)'/r and Φ (profile.h), 2^TABLE_BITS entries per octave of u, linear in between.
#ifndef TABLE_BITS
#define TABLE_BITS 5
#endif
#ifndef SUBTREE_LEVELS
#define SUBTREE_LEVELS 8
#endif
#define MOMENTS 10

typedef struct {
  global const float4* entry;
  float part;
} place;

place find(global const float4* restrict table, const float smooth2, const float r2) {
  const int shift = 23 - TABLE_BITS;
  const int bits = as_int(r2 + smooth2) - as_int(smooth2);
  place p;
  p.entry = table + 4 * (bits >> shift);
  p.part = (float)(bits & ((1 << shift) - 1)) / (float)(1 << shift);
  return p;
}

float4 looked_up(const place p, const int what) {
  return mix(p.entry[what], p.entry[what + 4], p.part);
}

// Moments of a leaf's triangles, positions [begin, end), from their irradiance, which lies in the
// mesh's order.
void pull_leaf(const int k, const int begin, const int end, global const int* restrict order,
               global const float4* restrict irradiance, global const float4* restrict point,
               global const float4* restrict spread, global const float4* restrict cluster,
               global float4* restrict power, global float4* restrict moments) {
  const float4 centre = cluster[k];
  float4 m[MOMENTS];
  for (int q = 0; q < MOMENTS; ++q) m[q] = (float4)(0.0f);
  for (int p = begin; p < end; ++p) {
    const float4 e = irradiance[order[p]] * point[p].w;
    const float x = point[p].x - centre.x, y = point[p].y - centre.y, z = point[p].z - centre.z;
    const float4 own = spread[2 * p], mixed = spread[2 * p + 1];
    power[p] = e;
    m[0] += e;
    m[1] += e * x;
    m[2] += e * y;
    m[3] += e * z;
    m[4] += e * (x * x + own.x);
    m[5] += e * (y * y + own.y);
    m[6] += e * (z * z + own.z);
    m[7] += e * (x * y + mixed.x);
    m[8] += e * (x * z + mixed.y);
    m[9] += e * (y * z + mixed.z);
  }
  for (int q = 0; q < MOMENTS; ++q) moments[MOMENTS * k + q] = m[q];
}

// Moments of a cluster from its children's.
void pull_children(const int k, global const float4* restrict cluster,
                   global float4* restrict moments) {
  float4 m[MOMENTS];
  for (int q = 0; q < MOMENTS; ++q) m[q] = (float4)(0.0f);
  for (int child = 2 * k + 1; child <= 2 * k + 2; ++child) {
    const float4 d = cluster[child] - cluster[k];
    global const float4* c = moments + MOMENTS * child;
    const float4 p = c[0], px = c[1], py = c[2], pz = c[3];
    m[0] += p;
    m[1] += px + p * d.x;
    m[2] += py + p * d.y;
    m[3] += pz + p * d.z;
    m[4] += c[4] + (2.0f * px + p * d.x) * d.x;
    m[5] += c[5] + (2.0f * py + p * d.y) * d.y;
    m[6] += c[6] + (2.0f * pz + p * d.z) * d.z;
    m[7] += c[7] + px * d.y + (py + p * d.y) * d.x;
    m[8] += c[8] + px * d.z + (pz + p * d.z) * d.x;
    m[9] += c[9] + py * d.z + (pz + p * d.z) * d.y;
  }
  for (int q = 0; q < MOMENTS; ++q) moments[MOMENTS * k + q] = m[q];
}

// Moments of subtrees, whose roots are the clusters [count - 1, 2 count - 1). `first`: of each leaf's
// positions.
kernel void pull_subtrees(const int count, const int levels, global const int* restrict first,
                          global const int* restrict order,
                          global const float4* restrict irradiance,
                          global const float4* restrict point, global const float4* restrict spread,
                          global const float4* restrict cluster, global float4* restrict power,
                          global float4* restrict moments) {
  const int i = (int)get_global_id(0);
  if (i >= count) return;
  for (int leaf = i << levels; leaf < (i + 1) << levels; ++leaf) {
    pull_leaf((count << levels) - 1 + leaf, first[leaf], first[leaf + 1], order, irradiance, point,
              spread, cluster, power, moments);
  }
  for (int l = levels - 1; l >= 0; --l) {
    for (int c = i << l; c < (i + 1) << l; ++c)
      pull_children((count << l) - 1 + c, cluster, moments);
  }
}

// Moments of the clusters of one level, [count - 1, 2 count - 1).
kernel void pull(const int count, global const float4* restrict cluster,
                 global float4* restrict moments) {
  const int i = (int)get_global_id(0);
  if (i < count) pull_children(count - 1 + i, cluster, moments);
}

// Adds to a cluster's Taylor series what its links bring, from `first` on each `step`th: K(x − y) and
// its derivatives are K, G d, G I + H ddᵀ with d between the centres, G = K'/r, H = G'/r.
void add_links(const int k, const int first, const int step, const float smooth2,
               global const float4* restrict table,
               global const int2* restrict range, global const int* restrict emitter,
               global const float4* restrict cluster, global const float4* restrict moments,
               float4* m) {
  const float4 centre = cluster[k];
  const int end = range[k].x + range[k].y;
  for (int l = range[k].x + first; l < end; l += step) {
    const int e = emitter[l];
    const float x = centre.x - cluster[e].x, y = centre.y - cluster[e].y,
                z = centre.z - cluster[e].z;
    global const float4* s = moments + MOMENTS * e;
    const place at = find(table, smooth2, x * x + y * y + z * z);
    const float4 R = looked_up(at, 0), G = looked_up(at, 1), H = looked_up(at, 2);
    const float4 p = s[0], px = s[1], py = s[2], pz = s[3];
    const float4 along = px * x + py * y + pz * z;
    const float4 across = s[4] * (x * x) + s[5] * (y * y) + s[6] * (z * z) +
                          2.0f * (s[7] * (x * y) + s[8] * (x * z) + s[9] * (y * z));
    const float4 pG = p * G, pH = p * H, radial = pG - H * along;
    m[0] += p * R - G * along + 0.5f * (G * (s[4] + s[5] + s[6]) + H * across);
    m[1] += radial * x - G * px;
    m[2] += radial * y - G * py;
    m[3] += radial * z - G * pz;
    m[4] += pG + pH * (x * x);
    m[5] += pG + pH * (y * y);
    m[6] += pG + pH * (z * z);
    m[7] += pH * (x * y);
    m[8] += pH * (x * z);
    m[9] += pH * (y * z);
  }
}

// A parent's series about a centre `d` from its own.
void moved(const float4* s, const float4 d, float4* m) {
  const float4 hx = s[4] * d.x + s[7] * d.y + s[8] * d.z;
  const float4 hy = s[7] * d.x + s[5] * d.y + s[9] * d.z;
  const float4 hz = s[8] * d.x + s[9] * d.y + s[6] * d.z;
  m[0] = s[0] + (s[1] + 0.5f * hx) * d.x + (s[2] + 0.5f * hy) * d.y + (s[3] + 0.5f * hz) * d.z;
  m[1] = s[1] + hx;
  m[2] = s[2] + hy;
  m[3] = s[3] + hz;
  for (int q = 4; q < MOMENTS; ++q) m[q] = s[q];
}

// Series of the clusters of one level, [count - 1, 2 count - 1): their parents' and their links'.
kernel void push(const int count, const float smooth2, global const float4* restrict table,
                 global const int2* restrict range, global const int* restrict emitter,
                 global const float4* restrict cluster, global const float4* restrict moments,
                 global float4* restrict series) {
  const int i = (int)get_global_id(0);
  if (i >= count) return;
  const int k = count - 1 + i, parent = (k - 1) / 2;
  float4 s[MOMENTS], m[MOMENTS];
  for (int q = 0; q < MOMENTS; ++q) s[q] = k > 0 ? series[MOMENTS * parent + q] : (float4)(0.0f);
  moved(s, k > 0 ? cluster[k] - cluster[parent] : (float4)(0.0f), m);
  add_links(k, 0, 1, smooth2, table, range, emitter, cluster, moments, m);
  for (int q = 0; q < MOMENTS; ++q) series[MOMENTS * k + q] = m[q];
}

// ∫ R_d over the triangle as seen from `at`: edge integrals of Φ (form_factor.h), four Gauss points
// to a panel of u = asinh(t/S).
float4 form_factor(global const float4* restrict corner, const float4 at, const float smooth2,
                   global const float4* restrict table) {
  const float node[4] = {-0.86113631f, -0.33998104f, 0.33998104f, 0.86113631f};
  const float weight[4] = {0.34785485f, 0.65214515f, 0.65214515f, 0.34785485f};
  const float3 point = at.xyz;
  const float3 n = normalize(cross(corner[1].xyz - corner[0].xyz, corner[2].xyz - corner[0].xyz));
  const float height = dot(n, point - corner[0].xyz), h2 = height * height;
  const float4 at_foot = looked_up(find(table, smooth2, h2), 3);
  float4 sum = (float4)(0.0f);
  for (int edge = 0; edge < 3; ++edge) {
    const float3 a = corner[edge].xyz - point, b = corner[(edge + 1) % 3].xyz - point;
    const float3 along = normalize(b - a);
    const float R = -dot(n, cross(along, a));
    const float S = sqrt(R * R + h2 + smooth2);
    const float first = asinh(dot(along, a) / S), last = asinh(dot(along, b) / S);
    const int panels = max(1, (int)ceil((last - first) / 1.5f));
    const float half_panel = 0.5f * (last - first) / panels;
    for (int p = 0; p < panels; ++p) {
      for (int g = 0; g < 4; ++g) {
        const float grown = exp(first + half_panel * (2 * p + 1 + node[g]));
        const float t = 0.5f * S * (grown - 1.0f / grown), dt = 0.5f * S * (grown + 1.0f / grown);
        const float r2 = R * R + t * t;
        const float4 beyond = looked_up(find(table, smooth2, r2 + h2), 3);
        if (r2 > 0.0f) sum += half_panel * weight[g] * dt * R / r2 * (at_foot - beyond);
      }
    }
  }
  return sum;
}

// A leaf's series at a distance d from its centre.
float4 of_series(const float4* s, const float4 d) {
  return s[0] + s[1] * d.x + s[2] * d.y + s[3] * d.z +
         0.5f * (s[4] * (d.x * d.x) + s[5] * (d.y * d.y) + s[6] * (d.z * d.z)) +
         s[7] * (d.x * d.y) + s[8] * (d.x * d.z) + s[9] * (d.y * d.z);
}

// `value` with what reaches the triangle at position p from near leaves, from place `begin` of their
// list on each `step`th: triangle by triangle, each by its moments where they are enough (`opening`
// as for links, between a triangle and a point), else by its form factor.
float4 with_near(float4 value, const int p, const int begin, const int end, const int step,
                 const float smooth2, const float smooth, const float opening, const float decay,
                 global const float4* restrict table, global const int* restrict first,
                 global const int* restrict near, global const float4* restrict point,
                 global const float4* restrict spread, global const float4* restrict corner,
                 global const float4* restrict power) {
  for (int l = begin; l < end; l += step) {
    const int e_end = first[near[l] + 1];
    for (int e = first[near[l]]; e < e_end; ++e) {
      const float x = point[p].x - point[e].x, y = point[p].y - point[e].y,
                  z = point[p].z - point[e].z;
      const float r2 = x * x + y * y + z * z;
      const float4 own = spread[2 * e], mixed = spread[2 * e + 1];
      const float distance = sqrt(r2 + smooth * smooth);
      if (mixed.w * (3.0f + decay * distance) <= 3.0f * opening * distance) {
        const place at = find(table, smooth2, r2);
        const float across = own.x * x * x + own.y * y * y + own.z * z * z +
                             2.0f * (mixed.x * x * y + mixed.y * x * z + mixed.z * y * z);
        value += power[e] * (looked_up(at, 0) + 0.5f * (looked_up(at, 1) * (own.x + own.y + own.z) +
                                                        looked_up(at, 2) * across));
      } else {
        value += power[e] / point[e].w * form_factor(corner + 3 * e, point[p], smooth2, table);
      }
    }
  }
  return value;
}

// Exitance at the centroids of a leaf's triangles, in the mesh's order: the leaf's series `s`, and
// the leaves near it.
void evaluate(const int leaf, const float4 centre, const float4* s, const float smooth2,
              const float smooth, const float opening, const float decay,
              global const float4* restrict table, global const int* restrict first,
              global const int2* restrict range, global const int* restrict near,
              global const int* restrict order, global const float4* restrict point,
              global const float4* restrict spread, global const float4* restrict corner,
              global const float4* restrict power, global float4* restrict exitance) {
  for (int p = first[leaf]; p < first[leaf + 1]; ++p) {
    exitance[order[p]] = with_near(of_series(s, point[p] - centre), p, range[leaf].x,
                                   range[leaf].x + range[leaf].y, 1, smooth2, smooth, opening,
                                   decay, table, first, near, point, spread, corner, power);
  }
}

// Series of subtrees, whose roots are the clusters [count - 1, 2 count - 1) and have theirs, down to
// the leaves, and what these then evaluate.
kernel void evaluate_subtrees(
    const int count, const int levels, const float smooth2, const float smooth,
    const float opening, const float decay, global const float4* restrict table,
    global const int* restrict first, global const int2* restrict cluster_range, global const int* restrict emitter,
    global const int2* restrict leaf_range, global const int* restrict near,
    global const int* restrict order, global const float4* restrict point,
    global const float4* restrict spread, global const float4* restrict corner,
    global const float4* restrict cluster, global const float4* restrict power,
    global const float4* restrict moments, global const float4* restrict series,
    global float4* restrict exitance) {
  const int i = (int)get_global_id(0);
  if (i >= count) return;
  float4 down[SUBTREE_LEVELS + 1][MOMENTS];  // from the root to the leaf
  for (int q = 0; q < MOMENTS; ++q) down[0][q] = series[MOMENTS * (count - 1 + i) + q];
  for (int leaf = i << levels; leaf < (i + 1) << levels; ++leaf) {
    // Clusters that begin with this leaf.
    for (int l = 1; l <= levels; ++l) {
      if ((leaf & ((1 << (levels - l)) - 1)) != 0) continue;
      const int k = (count << l) - 1 + (leaf >> (levels - l));
      moved(down[l - 1], cluster[k] - cluster[(k - 1) / 2], down[l]);
      add_links(k, 0, 1, smooth2, table, cluster_range, emitter, cluster, moments, down[l]);
    }
    evaluate(leaf, cluster[(count << levels) - 1 + leaf], down[levels], smooth2, smooth, opening,
             decay, table, first, leaf_range, near, order, point, spread, corner, power, exitance);
  }
}
