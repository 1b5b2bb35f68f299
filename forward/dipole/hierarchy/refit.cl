// Triangles and clusters after vertices have moved (cluster_tree.h). Besides centre and radius a
// cluster has its area with Σ area · d² about the centre, and the box of its centroids: 2 vectors.
// Lengths in mm.
typedef struct {
  float4 centre;  // and radius
  float2 weight;
  float4 low, high;
} extent;

// A cluster has triangles of two sides where the farthest corner of its box is this many radii away,
// or this many radii of a disc of its area: a square aslant has 2.1 of both.
#define MOST_RADII 2.2f
#define MOST_DISC_RADII 4.0f

void add_part(extent* a, const float4 centre, const float2 weight) {
  const float whole = a->weight.x + weight.x, share = whole > 0.0f ? weight.x / whole : 0.0f;
  const float3 apart = centre.xyz - a->centre.xyz;
  a->weight.y += weight.y + a->weight.x * share * dot(apart, apart);
  a->weight.x = whole;
  a->centre.xyz += share * apart;
}

void put_extent(extent a, const int k, global float4* restrict cluster,
                global float2* restrict weight, global float4* restrict box) {
  const float area = fmax(a.weight.x, 1e-30f), radius = sqrt(2.0f * a.weight.y / area);
  const float3 corner = fmax(a.high.xyz - a.centre.xyz, a.centre.xyz - a.low.xyz);
  const float farthest = length(corner), disc = sqrt(area / M_PI_F);
  const int two_sides = farthest > MOST_RADII * radius || farthest > MOST_DISC_RADII * disc;
  a.centre.w = two_sides ? fmax(radius, farthest) : radius;
  cluster[k] = a.centre;
  weight[k] = a.weight;
  box[2 * k] = a.low;
  box[2 * k + 1] = a.high;
}

// Centroid with area, spread about it and corners of the triangle at position p; returns the sum of
// its squared spread [mm²].
float refit_triangle(const int p, const int t, global const int* restrict index,
                     global const float* restrict vertex, global float4* restrict point,
                     global float4* restrict spread, global float4* restrict corner) {
  const float3 a = vload3(index[3 * t], vertex), b = vload3(index[3 * t + 1], vertex),
               c = vload3(index[3 * t + 2], vertex);
  const float3 centre = (a + b + c) / 3.0f;
  const float3 da = a - centre, db = b - centre, dc = c - centre;
  const float3 own = (da * da + db * db + dc * dc) / 12.0f;
  const float3 mixed = (da.xxy * da.yzz + db.xxy * db.yzz + dc.xxy * dc.yzz) / 12.0f;
  const float trace = own.x + own.y + own.z;
  point[p] = (float4)(centre, 0.5f * length(cross(b - a, c - a)));
  spread[2 * p] = (float4)(own, 0.0f);
  spread[2 * p + 1] = (float4)(mixed, sqrt(2.0f * trace));
  corner[3 * p] = (float4)(a, 0.0f);
  corner[3 * p + 1] = (float4)(b, 0.0f);
  corner[3 * p + 2] = (float4)(c, 0.0f);
  return trace;
}

void refit_children(const int k, global float4* restrict cluster, global float2* restrict weight,
                    global float4* restrict box) {
  const int one = 2 * k + 1, other = 2 * k + 2;
  extent a = {cluster[one], weight[one], fmin(box[2 * one], box[2 * other]),
              fmax(box[2 * one + 1], box[2 * other + 1])};
  add_part(&a, cluster[other], weight[other]);
  put_extent(a, k, cluster, weight, box);
}

// Triangles and clusters of subtrees, whose roots are the clusters [count - 1, 2 count - 1).
kernel void refit_subtrees(const int count, const int levels, global const int* restrict first,
                           global const int* restrict order, global const int* restrict index,
                           global const float* restrict vertex, global float4* restrict point,
                           global float4* restrict spread, global float4* restrict corner,
                           global float4* restrict cluster, global float2* restrict weight,
                           global float4* restrict box) {
  const int i = (int)get_global_id(0);
  if (i >= count) return;
  for (int leaf = i << levels; leaf < (i + 1) << levels; ++leaf) {
    const int begin = first[leaf], end = first[leaf + 1];
    extent a;
    for (int p = begin; p < end; ++p) {
      const float trace = refit_triangle(p, order[p], index, vertex, point, spread, corner);
      const float4 centre = point[p];
      if (p == begin) a = (extent){centre, (float2)(0.0f), centre, centre};
      add_part(&a, centre, (float2)(centre.w, centre.w * trace));
      a.low = fmin(a.low, centre);
      a.high = fmax(a.high, centre);
    }
    put_extent(a, (count << levels) - 1 + leaf, cluster, weight, box);
  }
  for (int l = levels - 1; l >= 0; --l) {
    for (int c = i << l; c < (i + 1) << l; ++c)
      refit_children((count << l) - 1 + c, cluster, weight, box);
  }
}

// Clusters of one level, [count - 1, 2 count - 1), from their children.
kernel void refit(const int count, global float4* restrict cluster, global float2* restrict weight,
                  global float4* restrict box) {
  const int i = (int)get_global_id(0);
  if (i < count) refit_children(count - 1 + i, cluster, weight, box);
}
