// A step of conjugate gradients on red cells as one sweep (grid_stream_prelude.cl), and its
// scalars.

// Below this share of z·Sz, p'·Sp' is taken for lost. Directions as good as a hundred iterations
// can use keep well more.
#define LEAST_LEFT ((ACCU)0.1)

// The scalars of the next step from `up_sums` sums of stream_up and `step_sums` of the last
// stream_step; scalars: {γ, α, β}. p'·Sp' = z·Sz − β² p·Sp because p' = z + β p is conjugate to p
// (Chronopoulos & Gear 1989), so that α is known before p' is. Where hardly anything is left of
// that difference, rounding has made p' anything but conjugate (a replaced residual may even have
// grown along the slowest modes): that pattern starts again from z.
kernel void step_scalars(const int up_sums, const int step_sums, const int fresh,
                         global const accu_vec* restrict dots,
                         global const accu_vec* restrict steps, global accu_vec* restrict scalars) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0) return;
  accu_vec gamma = (accu_vec)(0), delta = (accu_vec)(0), energy = (accu_vec)(0);
  for (int i = 0; i < up_sums; ++i) {
    gamma += dots[2 * i];
    delta += dots[2 * i + 1];
  }
  accu_vec beta = (accu_vec)(0);
  if (!fresh) {
    for (int i = 0; i < step_sums; ++i) energy += steps[2 * i + 1];
    beta = ratio(gamma, scalars[0]);
  }
  const accu_vec left = delta - beta * beta * energy, least = LEAST_LEFT * delta;
  const accu_vec zero = (accu_vec)(0);
  scalars[0] = gamma;
  scalars[1] = ratio(gamma, left > least ? left : delta);
  scalars[2] = left > least ? beta : zero;
}

// What solving a black cell for its neighbours left over by rounding, −(A φ) / D: φ is exact to the
// second order with this added. (S φ) at a red cell then keeps the little that weak sinks draw
// beside what strong bonds carry, of which rounding φ alone takes 6e-8.
#define LEFT_OVER(g, v, e) (-(g).smoother * IMAGE(g, v, e))

// Rows of a ring that keeps black cells only, the e-th of a row at [e].
INLINE Rows rows_of_halves(Ring ring, int y, int z, int parity) {
  Rows rows;
  rows.here = ring_row(ring, y, z);
  rows.west = rows.here + parity - 1;
  rows.south = ring_row(ring, y - 1, z);
  rows.north = ring_row(ring, y + 1, z);
  rows.down = rows.here - ring.row;
  rows.up = rows.here + ring.row;
  return rows;
}

// p' = z + β p, d += α p', r −= α S p', all on red cells; sums [plane of a tile][2] (first_sum):
// Σ r² and Σ p'·Sp'. With first_p or first_d, p or d is taken for zero, whatever it holds.
kernel void stream_step(TILE_ARGUMENTS, const int first_p, const int first_d, GRID_ARGUMENTS,
                        global const accu_vec* restrict scalars, global const vec* restrict z,
                        global const vec* restrict before, global vec* restrict p,
                        global vec* restrict d, global vec* restrict r,
                        global accu_vec* restrict sums, const int scratch_cells,
                        global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  const Box black = around(own, 1, nx, ny, nz), red = around(own, 2, nx, ny, nz);
  const Ring ring = make_split_ring(TILE_SCRATCH, 4, red);
  clear(ring.planes, ring.depth * ring.plane);
  // Of black cells, one in every pair x, x + 1; rows of one plane keep their colour in the ring,
  // whose depth is even.
  Box halves = red;
  halves.x0 >>= 1;
  halves.x1 = (halves.x1 + 1) >> 1;
  const Ring rest = make_ring(TILE_SCRATCH + ring.depth * ring.plane, 4, halves);
  clear(rest.planes, rest.depth * rest.plane);
  const vec alpha = to_vec(scalars[1]), beta = to_vec(scalars[2]);
  sums += 2 * first_sum(own, tile_x, tile_z, nx, ny);
  for (int t = red.y0; t < own.y1 + 2; ++t) {
    if (t >= red.y1) {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
      clear(rest.planes + t % rest.depth * rest.plane, rest.plane);
    }
    accu_vec sum_rr = (accu_vec)(0), sum_energy = (accu_vec)(0);
    for (int k = red.z0; k < red.z1; ++k) {
      const int parity = PARITY(RED, t, k), m = t - 1, y = t - 2;
      const Span all = span_of(red, red.y0, k, parity), reds = span_of(red, t, k, parity),
                 blacks = span_of(black, m, k, parity), owns = span_of(own, y, k, parity);
      global vec* out0 = half_row(ring, t, k, parity);
      global vec* out = half_row(ring, m, k, parity);
      global vec* left_out = ring_row(rest, m, k);
      const Rows vm = rows_at(ring, m, k, parity), v = rows_at(ring, y, k, parity),
                 left = rows_of_halves(rest, y, k, parity);
      global const Stencil* gm = stencils + STENCIL_ROW(m, k, parity);
      global const Stencil* g = stencils + STENCIL_ROW(y, k, parity);
      const size_t row0 = RED_ROW(t, k), row = RED_ROW(y, k);
      // What comes next is fetched meanwhile: r and d for the plane after, the others one ahead.
      const int ahead = min(t + 1, ny - 1);
      global const Stencil* next_g = stencils + STENCIL_ROW(ahead, k, 0);
      const size_t next = RED_ROW(ahead, k), now = RED_ROW(max(m, 0), k);
      vec rr = (vec)(0), energy = (vec)(0);
      for (long e = all.begin; e < all.end; ++e) {
        PREFETCH(z + next + e);
        PREFETCH(before + next + e);
        if (WITHIN(reds, e)) {
          out0[e] = first_p ? z[row0 + e] : z[row0 + e] + beta * before[row0 + e];
        }
        PREFETCH_STENCILS(next_g, e);
        if (WITHIN(blacks, e)) {
          out[e] = gm[e].smoother * INFLOW(gm[e], vm, e);
          left_out[e] = LEFT_OVER(gm[e], vm, e);
        }
        PREFETCH(r + now + e);
        PREFETCH(d + now + e);
        if (WITHIN(owns, e)) {
          const size_t i = row + e;
          const vec here = v.here[e];
          const vec image = IMAGE(g[e], v, e) - INFLOW(g[e], left, e);
          const vec residual = r[i] - alpha * image;
          STREAM_OUT(here, p + i);
          d[i] = first_d ? alpha * here : d[i] + alpha * here;
          r[i] = residual;
          rr += residual * residual;
          energy += here * image;
        }
      }
      sum_rr += to_accu(rr);
      sum_energy += to_accu(energy);
    }
    if (t - 2 < own.y0) continue;
    sums[2 * (t - 2)] = sum_rr;
    sums[2 * (t - 2) + 1] = sum_energy;
  }
}
