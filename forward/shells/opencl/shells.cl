// Fur of one tile that repeats over a plane, drawn from the top shell down (forward/shells/frame.h
// has the host's reference, device_frame.h the caller).
//
// light:  what each texel with hair sends to the eye, once a frame; eight texels per work item.
//           L = c ((sky . T) / 4 pi + sum over lamps E clamp(Y(l) . T) p(t, l, v))
// pack:   premultiplied texels, L alpha and alpha with alpha = 1 - exp(-r rho h s), of a few slants
//         s = 1 / cosine; one texel per work item.
// blend:  eight pixels of a row per work item, two per vector:
//           sum += (1 - sum.alpha) texel, until all eight are opaque.
// spread: pixels between rays that are two pixels apart, as the mean of their neighbours.
//
// Numbers of `blend` are 16-bit shares of 1: of the tile's width (places, 32 bits, which wrap by
// themselves), of `white` (colours) and of 1 (opacity, weights). A product loses 2^-16 at most.
// A slice of texels is (WIDTH + 1) x (WIDTH + 1): its last row and column repeat the first, so that
// four neighbours are two loads.

#ifndef WIDTH
#define WIDTH 64  // texels along x and y
#endif
#ifndef LAYERS
#define LAYERS 32  // at most 64
#endif
#ifndef COEFFICIENTS
#define COEFFICIENTS 25  // of the transfer, bands * bands
#endif
#ifndef OPAQUE
#define OPAQUE 64880  // 0.99: what lies below is left out
#endif

#define STRIDE (WIDTH + 1)
#define SLICE (STRIDE * STRIDE)

// Kajiya and Kay, as forward/shells/reflectance.h; `norm` [65] over |cos(t, v)|.
float8 reflected(float8 tx, float8 ty, float8 tz, float3 l, float3 v, __global const float* norm,
                 float shine, float8* lobe) {
  const float8 a = clamp(tx * l.x + ty * l.y + tz * l.z, -1.0f, 1.0f);
  const float8 b = clamp(tx * v.x + ty * v.y + tz * v.z, -1.0f, 1.0f);
  const float8 sine = sqrt(1.0f - a * a);
  const float8 along = max(sine * sqrt(1.0f - b * b) - a * b, 0.0f);
  const float8 p2 = along * along, p4 = p2 * p2, p16 = p4 * p4 * p4 * p4;
  const float8 place = fabs(b) * 64.0f;
  const int8 low = min(convert_int8(place), 63);
  const float8 share = place - convert_float8(low);
  float first[8], second[8];
  int at[8];
  vstore8(low, 0, at);
  for (int i = 0; i < 8; ++i) {
    first[i] = norm[at[i]];
    second[i] = norm[at[i] + 1];
  }
  const float8 n = (1.0f - share) * vload8(0, first) + share * vload8(0, second);
  *lobe = shine * p16 * p4 / n;
  return (1.0f - shine) * sine / (M_PI_F * M_PI_F);
}

// hair [item][6][8]: colour R, G, B, tangent x, y, z; transfer [item][coef][8].
// sky [coef][3]; lamps [lamp][6 + COEFFICIENTS]: direction, irradiance, harmonics.
// lit [item][3][8].
__kernel void light(int items, __global const float* hair, __global const float* transfer,
                    __global const float* sky, int lamps, __global const float* lamp,
                    float eye_x, float eye_y, float eye_z, float shine,
                    __global const float* norm, __global float* lit) {
  const int i = get_global_id(0);
  if (i >= items) return;
  const float8 red = vload8(6 * i, hair), green = vload8(6 * i + 1, hair),
               blue = vload8(6 * i + 2, hair);
  const float8 tx = vload8(6 * i + 3, hair), ty = vload8(6 * i + 4, hair),
               tz = vload8(6 * i + 5, hair);
  float8 sky_r = 0.0f, sky_g = 0.0f, sky_b = 0.0f;
  for (int k = 0; k < COEFFICIENTS; ++k) {
    const float8 t = vload8(COEFFICIENTS * i + k, transfer);
    sky_r += sky[3 * k] * t;
    sky_g += sky[3 * k + 1] * t;
    sky_b += sky[3 * k + 2] * t;
  }
  const float even = 0.25f / M_PI_F;
  float8 r = even * red * max(sky_r, 0.0f), g = even * green * max(sky_g, 0.0f),
         b = even * blue * max(sky_b, 0.0f);
  for (int k = 0; k < lamps; ++k) {
    __global const float* one = lamp + k * (6 + COEFFICIENTS);
    float8 t = 0.0f;
    for (int j = 0; j < COEFFICIENTS; ++j) {
      t += one[6 + j] * vload8(COEFFICIENTS * i + j, transfer);
    }
    t = clamp(t, 0.0f, 1.0f);
    float8 lobe;
    const float8 diffuse =
        reflected(tx, ty, tz, (float3)(one[0], one[1], one[2]), (float3)(eye_x, eye_y, eye_z),
                  norm, shine, &lobe);
    r += one[3] * t * (diffuse * red + lobe);
    g += one[4] * t * (diffuse * green + lobe);
    b += one[5] * t * (diffuse * blue + lobe);
  }
  vstore8(r, 3 * i, lit);
  vstore8(g, 3 * i + 1, lit);
  vstore8(b, 3 * i + 2, lit);
}

// `depth` [item][8]: r rho h of a texel; `place` [item][8]: its place in a volume of slices; of the
// last item, places beyond the texels repeat one. Volumes of air stay zero.
__kernel void pack(int items, __global const float* depth, __global const int* place,
                   __global const float* lit, float per_white, int slants,
                   __global const float* slant, __global ushort* texels) {
  const int i = get_global_id(0);
  if (i >= items) return;
  const float8 d = vload8(i, depth);
  const float8 r = min(per_white * vload8(3 * i, lit), 1.0f),
               g = min(per_white * vload8(3 * i + 1, lit), 1.0f),
               b = min(per_white * vload8(3 * i + 2, lit), 1.0f);
  for (int k = 0; k < slants; ++k) {
    const float8 alpha = 65535.0f * (1.0f - native_exp(-slant[k] * d));
    int red[8], green[8], blue[8], opaque[8];
    vstore8(convert_int8(r * alpha + 0.5f), 0, red);
    vstore8(convert_int8(g * alpha + 0.5f), 0, green);
    vstore8(convert_int8(b * alpha + 0.5f), 0, blue);
    vstore8(convert_int8(alpha + 0.5f), 0, opaque);
    __global ushort* volume = texels + (size_t)k * (LAYERS * SLICE * 4);
    for (int j = 0; j < 8; ++j) {
      const ushort4 texel = (ushort4)(red[j], green[j], blue[j], opaque[j]);
      const int at = place[8 * i + j];
      const int x = at % STRIDE, y = at / STRIDE % STRIDE;
      vstore4(texel, at, volume);
      if (x == 0) vstore4(texel, at + WIDTH, volume);
      if (y == 0) vstore4(texel, at + WIDTH * STRIDE, volume);
      if (x == 0 && y == 0) vstore4(texel, at + WIDTH * STRIDE + WIDTH, volume);
    }
  }
}

#if (WIDTH & (WIDTH - 1)) == 0
#define SPLIT(place) const uint8 whole_##place = place >> (32 - popcount((uint)(WIDTH - 1)))
#define SHARE(place) (place << popcount((uint)(WIDTH - 1)))
#else
#define SPLIT(place) const uint8 whole_##place = mul_hi(place, (uint8)(WIDTH))
#define SHARE(place) (place * (uint)WIDTH)
#endif

// The high half of a product: one instruction of a processor where it is written like this, many
// where as mul_hi().
ushort16 share_of(ushort16 a, ushort16 b) {
  return convert_ushort16((convert_uint16(a) * convert_uint16(b)) >> 16);
}

// Two pixels: texels a b over c d of each, weights across and down; not yet summed over a and b.
ushort16 two(__global const ushort* first, __global const ushort* second, ushort16 across,
             ushort16 down) {
  const ushort16 upper = (ushort16)(vload8(0, first), vload8(0, second));
  const ushort16 lower =
      (ushort16)(vload8(0, first + 4 * STRIDE), vload8(0, second + 4 * STRIDE));
  return share_of(share_of(upper, ~down) + share_of(lower, down), across);
}

// Blends four pixels, in the order 0, 2, 1, 3, of those that begin with index i.
#define FOUR(i, j, k, l, u_ij, u_kl, v_ij, v_kl, sum)                                    \
  {                                                                                      \
    const ushort16 p = two(at + index.s##i, at + index.s##j, u.u_ij, v.v_ij),            \
                   q = two(at + index.s##k, at + index.s##l, u.u_kl, v.v_kl);            \
    const ushort16 texel = (ushort16)(p.s0123, q.s0123, p.s89ab, q.s89ab) +              \
                           (ushort16)(p.s4567, q.s4567, p.scdef, q.scdef);               \
    sum += share_of(texel, ~sum.s33337777bbbbffff);                                      \
  }

// eye and ray in tiles; a pixel's ray is forward + (2 (x + 0.5) / columns - 1) right +
// (1 - 2 (y + 0.5) / rows) up, of z = -1 for each layer's height once scaled.
// shape[0..11]: eye x, y, height of the top shell below the eye in layers; forward, right, up in
// x, y [tiles] and z [layers]. first_slant, per_slant: k = (log2 s - first) per.
// filled [WIDTH][WIDTH]: layers with hair that a group whose first pixel is in that texel meets.
// Rays go through every `apart`-th pixel of every such row; `stride`: of seen, in pixels.
__kernel void blend(int columns, int rows, int apart, int stride, __global const float* shape,
                    __global const float* slant_of, __global const ushort* texels,
                    __global const ulong* filled, __global ushort* seen) {
  const int group = get_global_id(0), row = get_global_id(1);
  const int first = 8 * group;
  if (first >= stride || row > (rows - 1) / apart + apart - 1) return;
  const float8 column = (float)first + (float8)(0, 1, 2, 3, 4, 5, 6, 7);
  const float8 along = (2.0f * apart * column + 1.0f) / columns - 1.0f;
  const float down = 1.0f - (2.0f * apart * row + 1.0f) / rows;
  const float8 dx = shape[3] + along * shape[6] + down * shape[9],
               dy = shape[4] + along * shape[7] + down * shape[10],
               dz = shape[5] + along * shape[8] + down * shape[11];
  ushort16 sum = 0, other = 0;
  if (all(dz < -1e-3f)) {
    const float8 per_layer = -1.0f / dz;
    float8 step_x = dx * per_layer, step_y = dy * per_layer;
    float8 from_x = shape[0] + shape[2] * step_x, from_y = shape[1] + shape[2] * step_y;
    from_x -= floor(from_x);
    from_y -= floor(from_y);
    step_x -= floor(step_x);
    step_y -= floor(step_y);
    uint8 x = as_uint8(convert_int8(from_x * 2147483520.0f)) * 2u,
          y = as_uint8(convert_int8(from_y * 2147483520.0f)) * 2u;
    const uint8 next_x = as_uint8(convert_int8(step_x * 2147483520.0f)) * 2u,
                next_y = as_uint8(convert_int8(step_y * 2147483520.0f)) * 2u;
    // A layer's height in tiles is slant_of[3].
    const float high = slant_of[3];
    const float way = sqrt(dx.s3 * dx.s3 + dy.s3 * dy.s3 + dz.s3 * dz.s3 * high * high) *
                      per_layer.s3 / high;
    const int version = clamp((int)((log2(way) - slant_of[0]) * slant_of[1] + 0.5f), 0,
                              (int)slant_of[2]);
    __global const ushort* at = texels + ((size_t)version * LAYERS + LAYERS - 1) * SLICE * 4;
    for (int layer = LAYERS - 1; layer >= 0; --layer, at -= SLICE * 4) {
      SPLIT(x);
      SPLIT(y);
      if (filled[whole_y.s0 * WIDTH + whole_x.s0] >> layer & 1) {
        const uint8 index = 4u * (whole_y * (uint)STRIDE + whole_x);
        const ushort8 right = convert_ushort8(SHARE(x) >> 16),
                      v = convert_ushort8(SHARE(y) >> 16), left = ~right;
        // Weights of the left and the right texel, pixel by pixel.
        const ushort16 u =
            (ushort16)(left.s0, right.s0, left.s1, right.s1, left.s2, right.s2, left.s3, right.s3,
                       left.s4, right.s4, left.s5, right.s5, left.s6, right.s6, left.s7, right.s7);
        FOUR(0, 1, 2, 3, s0000111122223333, s4444555566667777, s0000000011111111,
             s2222222233333333, sum)
        FOUR(4, 5, 6, 7, s88889999aaaabbbb, sccccddddeeeeffff, s4444444455555555,
             s6666666677777777, other)
        const ushort16 least = min(sum, other);
        if (all(least.s37bf >= (ushort4)(OPAQUE))) break;
      }
      x += next_x;
      y += next_y;
    }
  }
  const ushort16 first_half = (ushort16)(sum.s0123, sum.s89ab, sum.s4567, sum.scdef),
                 second_half = (ushort16)(other.s0123, other.s89ab, other.s4567, other.scdef);
  __global ushort* to = seen + 4 * ((size_t)row * stride + first);
  vstore16(first_half, 0, to);
  vstore16(second_half, 1, to);
}

// rays [row / 2][from_stride]: every second pixel of every second row, one more than the frame has
// at the right and below. Sixteen pixels of a row per work item.
__kernel void spread(int rows, int from_stride, __global const ushort* rays, int stride,
                     __global ushort* seen) {
  const int first = 16 * get_global_id(0), row = get_global_id(1);
  if (first >= stride || row >= rows) return;
  __global const ushort* upper = rays + 4 * ((size_t)(row / 2) * from_stride + first / 2);
  __global const ushort* lower = upper + 4 * (row % 2) * from_stride;
  __global ushort* to = seen + 4 * ((size_t)row * stride + first);
  for (int i = 0; i < 2; ++i, upper += 16, lower += 16, to += 32) {
    const ushort16 at = rhadd(vload16(0, upper), vload16(0, lower)),
                   next = rhadd(vload16(0, upper + 4), vload16(0, lower + 4)),
                   between = rhadd(at, next);
    vstore16((ushort16)(at.s0123, between.s0123, at.s4567, between.s4567), 0, to);
    vstore16((ushort16)(at.s89ab, between.s89ab, at.scdef, between.scdef), 1, to);
  }
}
