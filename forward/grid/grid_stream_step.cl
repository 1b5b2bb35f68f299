// A step of conjugate gradients on red cells as one sweep (grid_stream_prelude.cl), and its scalars.

// Below this share of z·Sz, p'·Sp' is taken for lost. Directions as good as a hundred iterations can
// use keep well more.
#define LEAST_LEFT ((ACCU)0.1)

// The scalars of the next step from `up_tiles` sums of stream_up and `step_tiles` sums of the last
// stream_step; scalars: {γ, α, β}. p'·Sp' = z·Sz − β² p·Sp because p' = z + β p is conjugate to p
// (Chronopoulos & Gear 1989), so that α is known before p' is. Where hardly anything is left of that
// difference, rounding has made p' anything but conjugate (a replaced residual may even have grown
// along the slowest modes): that pattern starts again from z.
kernel void step_scalars(const int up_tiles, const int step_tiles, const int fresh,
                         global const accu_vec* restrict dots,
                         global const accu_vec* restrict steps, global accu_vec* restrict scalars) {
  if (get_global_id(0) > 0 || get_global_id(1) > 0) return;
  accu_vec gamma = (accu_vec)(0), delta = (accu_vec)(0), energy = (accu_vec)(0);
  for (int tile = 0; tile < up_tiles; ++tile) {
    gamma += dots[2 * tile];
    delta += dots[2 * tile + 1];
  }
  accu_vec beta = (accu_vec)(0);
  if (!fresh) {
    for (int tile = 0; tile < step_tiles; ++tile) energy += steps[2 * tile + 1];
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
#define LEFT_OVER(g, v, x, i) (-smoother[(i) + (x)] * IMAGE(g, v, x, i))

// Σ G (what is left over of the neighbours), which are kept in halves: cell x at x >> 1.
#define LEFT_OVER_INFLOW(g, v, x)                                                      \
  ((g).gx[x] * (v).here[((x)-1) >> 1] + (g).gx[(x) + 1] * (v).here[((x) + 1) >> 1] +   \
   (g).gy[x] * (v).south[(x) >> 1] + (g).gy_north[x] * (v).north[(x) >> 1] +           \
   (g).gz[x] * (v).down[(x) >> 1] + (g).gz_up[x] * (v).up[(x) >> 1])

// p' = z + β p, d += α p', r −= α S p', all on red cells; sums [tile][2]: Σ r² and Σ p'·Sp' of each
// tile. With first_p or first_d, p or d is taken for zero, whatever it holds.
kernel void stream_step(TILE_ARGUMENTS, const int first_p, const int first_d, GRID_ARGUMENTS,
                        global const REAL* restrict sink, global const REAL* restrict smoother,
                        global const accu_vec* restrict scalars, global const vec* restrict z,
                        global const vec* restrict before, global vec* restrict p,
                        global vec* restrict d, global vec* restrict r,
                        global accu_vec* restrict sums, const int scratch_cells,
                        global vec* restrict scratch) {
  const int tile = (int)get_global_id(1);
  const Box own = tile_box(tile, tile_x, tile_y, tile_z, nx, ny, nz);
  const Box black = around(own, 1, nx, ny, nz), red = around(own, 2, nx, ny, nz);
  const Ring ring = make_ring(TILE_SCRATCH, 4, red);
  clear(ring.planes, ring.depth * ring.plane);
  // Of black cells, one in every pair x, x + 1; rows of one plane keep their colour in the ring,
  // whose depth is even.
  Box halves = red;
  halves.x0 >>= 1;
  halves.x1 = (halves.x1 + 1) >> 1;
  const Ring rest = make_ring(TILE_SCRATCH + ring.depth * ring.plane, 4, halves);
  clear(rest.planes, rest.depth * rest.plane);
  const vec alpha = to_vec(scalars[1]), beta = to_vec(scalars[2]);
  accu_vec sum_rr = (accu_vec)(0), sum_energy = (accu_vec)(0);
  for (int t = red.y0; t < own.y1 + 2; ++t) {
    if (t < red.y1) {
      for (int k = red.z0; k < red.z1; ++k) {
        const size_t j = RED_CELL(0, t, k);
        global vec* out = ring_row(ring, t, k);
        for (int x = FIRST(red.x0, RED, t, k); x < red.x1; x += 2) {
          const int e = x >> 1;
          out[x] = first_p ? z[j + e] : z[j + e] + beta * before[j + e];
        }
      }
    } else {
      clear(ring.planes + t % ring.depth * ring.plane, ring.plane);
      clear(rest.planes + t % rest.depth * rest.plane, rest.plane);
    }
    if (t - 1 >= black.y0 && t - 1 < black.y1) {
      for (int k = black.z0; k < black.z1; ++k) {
        const Conductances g = conductances_at(gx, gy, gz, nx, ny, t - 1, k);
        const Rows v = rows_at(ring, t - 1, k);
        const size_t i = CELL(0, t - 1, k);
        global vec* out = ring_row(ring, t - 1, k);
        global vec* left = ring_row(rest, t - 1, k);
        // What comes next is fetched meanwhile: r and d for the plane after, the others one ahead.
        const int ahead = min(t + 1, ny - 1);
        const Coming coming = coming_row(nx, ny, ahead, k, gx, gy, gz, sink, smoother);
        const size_t next = RED_CELL(0, ahead, k), now = RED_CELL(0, max(t - 2, 0), k);
        for (int x = FIRST(black.x0, BLACK, t - 1, k); x < black.x1; x += 2) {
          fetch_coming(&coming, x);
          PREFETCH(z + next + (x >> 1));
          PREFETCH(before + next + (x >> 1));
          PREFETCH(r + now + (x >> 1));
          PREFETCH(d + now + (x >> 1));
          out[x] = smoother[i + x] * INFLOW(g, v, x);
          left[x >> 1] = LEFT_OVER(g, v, x, i);
        }
      }
    }
    const int y = t - 2;
    if (y < own.y0 || y >= own.y1) continue;
    for (int k = own.z0; k < own.z1; ++k) {
      const size_t i = CELL(0, y, k), j = RED_CELL(0, y, k);
      const Conductances g = conductances_at(gx, gy, gz, nx, ny, y, k);
      const Rows v = rows_at(ring, y, k), left = rows_at(rest, y, k);
      vec rr = (vec)(0), energy = (vec)(0);
      for (int x = FIRST(own.x0, RED, y, k); x < own.x1; x += 2) {
        const size_t e = j + (x >> 1);
        const vec here = v.here[x];
        const vec image = IMAGE(g, v, x, i) - LEFT_OVER_INFLOW(g, left, x);
        const vec residual = r[e] - alpha * image;
        STREAM_OUT(here, p + e);
        d[e] = first_d ? alpha * here : d[e] + alpha * here;
        r[e] = residual;
        rr += residual * residual;
        energy += here * image;
      }
      sum_rr += to_accu(rr);
      sum_energy += to_accu(energy);
    }
  }
  sums[2 * tile] = sum_rr;
  sums[2 * tile + 1] = sum_energy;
}
