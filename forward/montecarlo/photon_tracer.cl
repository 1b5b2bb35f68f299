// Radiative transfer in the voxels by following photons: collimated or Lambertian entry, Woodcock
// tracking (Woodcock et al. 1965), Henyey-Greenstein scattering, unpolarised Fresnel at the faces.
//
// Lengths are voxel edges. A photon's weight is an integer, `full_weight` at entry; whatever it
// loses is added to a tally, so that what enters is what leaves and what is absorbed, to the unit.
// Tallies are 64-bit integer sums: they do not depend on the order of the photons. Random numbers
// are a function of (seed, pattern, photon, event) alone: Philox4x32-10 (Salmon et al. 2011).

constant uint full_weight = 1u << 31;
// Lighter photons are absorbed whole or not at all: that ends them without creating energy.
constant uint light_weight = 1u << 25;
// Squares of weights are kept in units of (2^-16)², so that 2^32 of them fit 64 bits.
#define SQUARE_SHIFT 15
// Light that leaves within 10° of the normal is tallied once more for the radiance along it.
constant float cone_cosine = 0.98480775f;
constant float two_pi = 6.28318531f;

// In scalars and 64-bit products: PoCL makes mul_hi and vectors of four three times slower here.
uint4 philox(uint4 counter, uint2 key) {
  uint a = counter.x, b = counter.y, c = counter.z, d = counter.w, k = key.x, l = key.y;
  for (int round = 0; round < 10; ++round) {
    const ulong p = (ulong)a * 0xD2511F53u, q = (ulong)c * 0xCD9E8D57u;
    a = (uint)(q >> 32) ^ b ^ k;
    c = (uint)(p >> 32) ^ d ^ l;
    b = (uint)q;
    d = (uint)p;
    k += 0x9E3779B9u;
    l += 0xBB67AE85u;
  }
  return (uint4)(a, b, c, d);
}

uint product_high(uint a, uint b) {
  return (uint)(((ulong)a * b) >> 32);
}

// For the known-answer test. One item per counter.
kernel void philox_blocks(const uint key0, const uint key1, const int count,
                          global const uint4* restrict counters, global uint4* restrict blocks) {
  const int i = (int)get_global_id(0);
  if (i < count) blocks[i] = philox(counters[i], (uint2)(key0, key1));
}

// In (0, 1], fine near 0, where it matters to the logarithm.
float uniform_of(uint bits) {
  return fma((float)bits, 0x1p-32f, 0x1p-33f);
}

// tally += amount, exact, with 32-bit atomics only: the low word tells when it carries.
void add_to(volatile global uint* tally, ulong amount) {
  const uint low = (uint)amount;
  const uint before = atomic_add(tally, low);
  const uint high = (uint)(amount >> 32) + (before + low < before ? 1u : 0u);
  if (high != 0) atomic_add(tally + 1, high);
}

// Unpolarised reflectance inside at a cosine to the normal; 1 beyond the critical angle.
float fresnel_inside(float eta, float cosine, float* cosine_outside) {
  const float sine2 = eta * eta * (1 - cosine * cosine);
  if (sine2 >= 1) return 1;
  const float outside = sqrt(1 - sine2);
  const float parallel = (cosine - eta * outside) / (cosine + eta * outside);
  const float across = (eta * cosine - outside) / (eta * cosine + outside);
  *cosine_outside = outside;
  return 0.5f * (parallel * parallel + across * across);
}

// `direction` turned by a Henyey-Greenstein angle. The frame about it is Duff et al. 2017.
float3 scatter(float3 direction, float g, float u, float turn) {
  float cosine = 2 * u - 1;
  if (fabs(g) > 1e-4f) {
    const float part = (1 - g * g) / (1 - g + 2 * g * u);
    cosine = clamp((1 + g * g - part * part) / (2 * g), -1.0f, 1.0f);
  }
  const float sine = sqrt(1 - cosine * cosine);
  float across_cosine;
  const float across_sine = sincos(two_pi * turn, &across_cosine);
  const float a = sine * across_cosine, b = sine * across_sine;
  if (fabs(g) <= 1e-4f) return (float3)(a, b, cosine);
  const float sign = direction.z < 0 ? -1.0f : 1.0f;
  const float c = -1 / (sign + direction.z), d = direction.x * direction.y * c;
  const float3 first =
      (float3)(1 + sign * direction.x * direction.x * c, sign * d, -sign * direction.x);
  const float3 second = (float3)(d, sign + direction.y * direction.y * c, -direction.y);
  const float3 turned = a * first + b * second + cosine * direction;
  return turned * (1.5f - 0.5f * dot(turned, turned));  // keeps the length at 1
}

// Component along an axis, and the vector whose (axis, u, v) components these are: the u, v of
// core/grid.h's faces.
float along(float3 vector, int axis) {
  return axis == 0 ? vector.x : axis == 1 ? vector.y : vector.z;
}
float3 oriented(int axis, float normal, float u, float v) {
  return axis == 0   ? (float3)(normal, u, v)
         : axis == 1 ? (float3)(u, normal, v)
                     : (float3)(u, v, normal);
}

// Surface voxel at a point of a face, counted through all faces in order of all_faces.
int surface_pixel(int axis, int plus, int3 extent, float3 point) {
  const int3 cell = clamp(convert_int3_rtz(point), (int3)(0), extent - 1);
  const int x_face = extent.y * extent.z, y_face = extent.x * extent.z;
  if (axis == 0) return plus * x_face + cell.z * extent.y + cell.y;
  if (axis == 1) return 2 * x_face + plus * y_face + cell.z * extent.x + cell.x;
  return 2 * (x_face + y_face) + plus * extent.x * extent.y + cell.y * extent.x + cell.x;
}

// Henyey-Greenstein's phase function times 4 pi.
float phase(float g, float cosine) {
  const float part = 1 + g * g - 2 * g * cosine;
  return (1 - g * g) / (part * sqrt(part));
}

// Optical depth from `out`, on a face, back along `direction` for `length`, in coordinates that go
// on beyond mirrors at the block's faces: there its voxels lie mirrored.
float depth_before(float3 out, float3 direction, float length, int3 extent, float mean_step,
                   global const uint2* restrict voxels) {
  const float most = 16.0f;  // less than 2^-23 arrives
  const float3 back = -direction;
  const float3 per_cell = select((float3)(MAXFLOAT), fabs(1 / back), back != 0.0f);
  const int3 step = select((int3)(-1), (int3)(1), back > 0.0f);
  int3 cell = convert_int3_rtn(out);
  // On a plane between two cells it begins in the one that it goes into.
  cell = select(cell, cell - 1, convert_float3(cell) == out && back < 0.0f);
  const float3 wall = convert_float3(select(cell, cell + 1, back > 0.0f));
  float3 next = select((float3)(MAXFLOAT), (wall - out) / back, back != 0.0f);
  const float per_chance = 0x1p-32f / mean_step;
  float depth = 0, way = 0;
  while (way < length && depth < most) {
    const int axis = next.x <= next.y && next.x <= next.z ? 0 : next.y <= next.z ? 1 : 2;
    const float end = min(along(next, axis), length);
    int3 at = select(cell, -1 - cell, cell < 0);
    at = select(at, 2 * extent - 1 - at, at >= extent);
    at = clamp(at, (int3)(0), extent - 1);
    const float chance = (float)voxels[((size_t)at.z * extent.y + at.y) * extent.x + at.x].x;
    depth += (end - way) * chance * per_chance;
    way = end;
    if (axis == 0) next.x += per_cell.x, cell.x += step.x;
    if (axis == 1) next.y += per_cell.y, cell.y += step.y;
    if (axis == 2) next.z += per_cell.z, cell.z += step.z;
  }
  return depth;
}

// What a camera sees of light scattered at a point (next-event estimation): its radiance there,
// in units of the radiance that P1 gives an exitance of one full weight per pixel.
//   from, direction  of the light before it is scattered
//   two_a        2A of the boundary
//   far          nonzero: also by way of the face behind, weighed by `far`
//   view         per pixel of the face (axis, plus): sum of weights
void tally_view(float3 from, float3 direction, uint weight, float g, int3 extent, float mean_step,
                float eta, float two_a, int axis, int plus, int mirror_axes, float far,
                float3 camera, global const uint2* restrict voxels, volatile global uint* view) {
  const float3 top = convert_float3(extent);
  const float face = plus ? along(top, axis) : 0.0f;
  const float outward = plus ? 1.0f : -1.0f;
  // Light arrives straight, or as if from an image of the point behind a side or the far face.
  float3 sight = (float3)(0);
  for (int image = 0; image < (far > 0 ? 8 : 4); ++image) {
    float3 source = from, before = direction;
    for (int a = 0; a < 3; ++a) {
      const int bit = a == axis ? 4 : (a == (axis == 0 ? 1 : 0)) ? 1 : 2;
      if (!(image & bit)) continue;
      // Only the mirror that the line of sight comes from.
      const bool low = a == axis ? plus : along(sight, a) > 0;
      const float mirrored = low ? -along(from, a) : 2 * along(top, a) - along(from, a);
      if (a == 0) source.x = mirrored, before.x = -before.x;
      if (a == 1) source.y = mirrored, before.y = -before.y;
      if (a == 2) source.z = mirrored, before.z = -before.z;
    }
    float3 out = source, way = (float3)(0);
    float length = 0, distance = 1;
    for (int k = 0; k < 3; ++k) {  // the line of sight through the point
      if (k == 0) {
        if (axis == 0) out.x = face;
        if (axis == 1) out.y = face;
        if (axis == 2) out.z = face;
      }
      const float3 seen = camera - out;
      distance = sqrt(dot(seen, seen));
      way = seen / (distance * eta);
      const float across = dot(way, way) - along(way, axis) * along(way, axis);
      const float normal = outward * sqrt(1 - across);
      if (axis == 0) way.x = normal;
      if (axis == 1) way.y = normal;
      if (axis == 2) way.z = normal;
      length = (face - along(source, axis)) / normal;
      out = source + length * way;
      if (axis == 0) out.x = face;
      if (axis == 1) out.y = face;
      if (axis == 2) out.z = face;
    }
    if (image == 0) sight = way;
    if (any(out < 0.0f) || any(out > top)) continue;
    float share = image & 4 ? far : 1.0f, outside;
    for (int a = 0; a < 3; ++a) {
      const int bit = a == axis ? 4 : (a == (axis == 0 ? 1 : 0)) ? 1 : 2;
      if (!(image & bit) || (mirror_axes >> a & 1)) continue;
      share *= fresnel_inside(eta, fabs(along(way, a)), &outside);
    }
    const float cosine = fabs(along(way, axis));
    const float spread = 1 + length / (eta * distance);
    share *= exp(-depth_before(out, way, length, extent, mean_step, voxels)) /
             (cosine * (two_a + 3 * cosine) * spread * spread);
    if (fabs(g) > 1e-4f) share *= phase(g, dot(before, way));
    const int3 cell = clamp(convert_int3_rtz(out), (int3)(0), extent - 1);
    const int pixel = axis == 0   ? cell.z * extent.y + cell.y
                      : axis == 1 ? cell.z * extent.x + cell.x
                                  : cell.y * extent.x + cell.x;
    add_to(view + 2 * pixel, convert_ulong(share * (float)weight));
  }
}

// Photons first, first + 1, ... last - 1 of each pattern; one item per stride of photons and
// pattern of `patterns` (those that have light).
//   mean_step    1/majorant, in voxel edges
//   mirror_axes  bit a set: the two faces across axis a reflect all light
//   diffuse      nonzero: Lambertian entry, and all light that leaves counts as scattered
//   voxels       per voxel: (chance that a tentative collision is real, chance that a real one
//                absorbs), each in units of 2^-32
//   entry        per pattern and lit pixel: Walker's alias table (chance to stay, other pixel)
//   beam         of collimated entry, inside the block
//   points       x, y, z of each isotropic source; the patterns from `first_point` on
//   tally_fluence  nonzero: scattered light adds its weight to `fluence`, per pattern and voxel, at
//                every tentative collision
//   view_axis    faces across it are seen by cameras, at most one each; -1: none
//   cameras      x, y, z of the two faces' cameras and nonzero where there is one
//   view         per pattern, face and pixel: sum of weights as tally_view scores them
//   exits        per pattern and surface pixel: Σ weight, Σ weight²
//   totals       per pattern: absorbed, unscattered, then per face Σ weight, Σ weight² in the cone
kernel void trace(const int nx, const int ny, const int nz, const float mean_step, const float g,
                  const float eta, const int lit_face, const int mirror_axes, const int diffuse,
                  const uint seed_low, const uint seed_high, const ulong first, const ulong last,
                  const int pattern_count, global const int* restrict patterns,
                  global const uint2* restrict voxels, global const uint2* restrict entry,
                  const float beam_x, const float beam_y, const float beam_z, const int first_point,
                  global const float4* restrict points, const int tally_fluence,
                  volatile global uint* restrict fluence, const int view_axis, const float two_a,
                  global const float4* restrict cameras, volatile global uint* restrict view,
                  volatile global uint* restrict exits, volatile global uint* restrict totals) {
  if (get_global_id(1) >= (size_t)pattern_count) return;
  const int pattern = patterns[get_global_id(1)];
  const int3 extent = (int3)(nx, ny, nz);
  const float3 top = convert_float3(extent);
  const int lit_axis = lit_face / 2;
  const int lit_nu = lit_axis == 0 ? ny : nx;
  const int lit_pixels = lit_nu * (lit_axis == 2 ? ny : nz);
  const int surface_pixels = 2 * (ny * nz + nx * nz + nx * ny);
  const float inward = (lit_face & 1) ? -1.0f : 1.0f;
  const uint2 key = (uint2)(seed_low, seed_high);
  entry += (size_t)pattern * lit_pixels;
  exits += (size_t)pattern * surface_pixels * 4;
  totals += (size_t)pattern * 28;
  if (tally_fluence) fluence += (size_t)pattern * nx * ny * nz * 2;
  const bool from_point = pattern >= first_point;
  const int view_pixels = view_axis < 0    ? 0
                          : view_axis == 0 ? ny * nz
                          : view_axis == 1 ? nx * nz
                                           : nx * ny;
  view += (size_t)pattern * view_pixels * 4;

  ulong absorbed = 0, unscattered = 0;
  ulong next = first + get_global_id(0);
  uint photon = 0, event = 0, weight = 0;
  bool scattered = false;
  float3 position = (float3)(0), direction = (float3)(0);
  while (true) {
    if (weight == 0) {  // the last one is done: enter the next
      if (next >= last) break;
      photon = (uint)next;
      next += get_global_size(0);
      event = 0;
      weight = full_weight;
      scattered = diffuse != 0 || from_point;
      const uint4 r = philox((uint4)(photon, event++, (uint)pattern, 0), key);
      if (from_point) {
        position = points[pattern - first_point].xyz;
        direction = scatter((float3)(0, 0, 1), 0, uniform_of(r.x), uniform_of(r.y));
        continue;
      }
      uint pixel = product_high(r.x, (uint)lit_pixels);
      const uint2 choice = entry[pixel];
      if (r.y >= choice.x) pixel = choice.y;
      position = oriented(lit_axis, (lit_face & 1) ? along(top, lit_axis) : 0.0f,
                          (float)(pixel % lit_nu) + uniform_of(r.z),
                          (float)(pixel / lit_nu) + uniform_of(r.w));
      direction = (float3)(beam_x, beam_y, beam_z);
      if (diffuse) {
        const uint4 s = philox((uint4)(photon, event++, (uint)pattern, 0), key);
        const float cosine = sqrt(uniform_of(s.x)), sine = sqrt(1 - cosine * cosine);
        float across_cosine;
        const float across_sine = sincos(two_pi * uniform_of(s.y), &across_cosine);
        direction = oriented(lit_axis, inward * cosine, sine * across_cosine, sine * across_sine);
      }
    }

    const uint4 r = philox((uint4)(photon, event++, (uint)pattern, 0), key);
    float path = -log(uniform_of(r.x)) * mean_step;
    while (true) {
      const float3 end = position + path * direction;
      if (all(end >= 0.0f) && all(end <= top)) {
        position = end;
        break;
      }
      // On to the first face in the way; a component of zero never gets there.
      const float3 wall = select((float3)(0), top, direction > 0.0f);
      const float3 way =
          select((float3)(MAXFLOAT), (wall - position) / direction, direction != 0.0f);
      const int axis = way.x <= way.y && way.x <= way.z ? 0 : way.y <= way.z ? 1 : 2;
      const float reach = clamp(along(way, axis), 0.0f, path);
      path -= reach;
      position = clamp(position + reach * direction, (float3)(0), top);
      const float normal = along(direction, axis);
      const int plus = normal > 0 ? 1 : 0;
      if (axis == 0) position.x = wall.x;
      if (axis == 1) position.y = wall.y;
      if (axis == 2) position.z = wall.z;
      float outside = 0, reflectance = 1;
      if (!(mirror_axes >> axis & 1)) reflectance = fresnel_inside(eta, fabs(normal), &outside);
      bool leaves = reflectance < 1;
      if (leaves && reflectance > 0) {
        const uint4 s = philox((uint4)(photon, event++, (uint)pattern, 0), key);
        leaves = uniform_of(s.x) > reflectance;
      }
      if (!leaves) {
        if (axis == 0) direction.x = -direction.x;
        if (axis == 1) direction.y = -direction.y;
        if (axis == 2) direction.z = -direction.z;
        continue;
      }
      if (scattered) {
        const ulong root = (weight + (1u << (SQUARE_SHIFT - 1))) >> SQUARE_SHIFT;
        volatile global uint* pixel =
            exits + 4 * (size_t)surface_pixel(axis, plus, extent, position);
        add_to(pixel, weight);
        add_to(pixel + 2, root * root);
        if (outside > cone_cosine) {
          volatile global uint* cone = totals + 4 * (1 + 2 * axis + plus);
          add_to(cone, weight);
          add_to(cone + 2, root * root);
        }
      } else {
        unscattered += weight;
      }
      weight = 0;
      break;
    }
    if (weight == 0) continue;

    const int3 cell = min(convert_int3_rtz(position), extent - 1);
    const size_t index = ((size_t)cell.z * ny + cell.y) * nx + cell.x;
    if (tally_fluence && scattered) add_to(fluence + 2 * index, weight);
    const uint2 voxel = voxels[index];
    if (r.y > voxel.x) continue;  // not a real collision
    if (weight >= light_weight) {
      const uint loss = (uint)(((ulong)weight * voxel.y + 0x80000000u) >> 32);
      absorbed += loss;
      weight -= loss;
    } else if (r.y < product_high(voxel.x, voxel.y)) {
      absorbed += weight;
      weight = 0;
    }
    if (weight == 0) continue;
    for (int plus = 0; plus < 2 && view_axis >= 0; ++plus) {
      if (cameras[plus].w == 0.0f) continue;
      // Little comes by way of the far face: one collision of eight stands for all.
      const float far = ((photon ^ event) & 7) == 0 ? 8.0f : 0.0f;
      tally_view(position, direction, weight, g, extent, mean_step, eta, two_a, view_axis, plus,
                 mirror_axes, far, cameras[plus].xyz, voxels, view + 2 * plus * view_pixels);
    }
    direction = scatter(direction, g, uniform_of(r.z), uniform_of(r.w));
    scattered = true;
  }
  add_to(totals, absorbed);
  add_to(totals + 2, unscattered);
}
