// The operator of one grid level on a batch of fields, and its smoother.
//
//   (A φ)_i = Σ_faces G (φ_i − φ_neighbour) + S_i φ_i,     φ_neighbour = 0 outside the block
//
// in flux form: differences first, so that float keeps the small absorption S = μ h³ that the sum
// of a stored diagonal would round away.
//
// D = Σ G + S; `smoother` is 1/D of black cells (x+y+z odd), make_smoother's T of red ones
// (grid_assemble.cl).
//
// Layout. A field is [z][y][x][GROUPS] vectors of WIDTH patterns. Face conductances include the
// boundary faces (0 on mirrors): gx is [nz][ny][nx+1], gy [nz][ny+1][nx], gz [nz+1][ny][nx]; gx[x]
// lies between cells x−1 and x:
//
//        gx[0]     gx[1]     gx[2]              gx[nx]
//          |  x=0    |  x=1    |      ...          |
//
// Work: one item per vector group and segment of a row of x: global id 0 = group + GROUPS segment,
// 1 = row = y + ny z.

#define ROW_SETUP                                                            \
  const int group = (int)get_global_id(0) % GROUPS;                          \
  const int segment = (int)get_global_id(0) / GROUPS;                        \
  const int segments = (nx - 1) / SEGMENT + 1;                               \
  const int row = (int)get_global_id(1);                                     \
  if (segment >= segments || row >= ny * nz) return;                         \
  const int x_begin = segment * SEGMENT, x_end = min(nx, x_begin + SEGMENT); \
  const int y = row % ny, z = row / ny;                                      \
  const int south = y > 0 ? nx * GROUPS : 0;                                 \
  const int north = y + 1 < ny ? nx * GROUPS : 0;                            \
  const int down = z > 0 ? nx * ny * GROUPS : 0;                             \
  const int up = z + 1 < nz ? nx * ny * GROUPS : 0;                          \
  const int has_south = y > 0, has_north = y + 1 < ny;                       \
  const int has_down = z > 0, has_up = z + 1 < nz;                           \
  gx += (size_t)row * (nx + 1);                                              \
  gy += ((size_t)z * (ny + 1) + y) * nx;                                     \
  gz += (size_t)row * nx;                                                    \
  const size_t first = (size_t)row * nx * GROUPS + group;

#define LEVEL_ARGUMENTS                                                     \
  const int nx, const int ny, const int nz, global const REAL *restrict gx, \
      global const REAL *restrict gy, global const REAL *restrict gz

// y = A x, and per segment Σ x·y in `partial` [row][segment][GROUPS].
kernel void apply_dot(LEVEL_ARGUMENTS, global const REAL* restrict sink,
                      global const vec* restrict in, global vec* restrict out,
                      global accu_vec* restrict partial) {
  ROW_SETUP
  sink += (size_t)row * nx;
  in += first;
  out += first;
  accu_vec sum = (accu_vec)(0);
  vec west = x_begin > 0 ? in[(x_begin - 1) * GROUPS] : (vec)(0), here = in[x_begin * GROUPS];
  for (int x = x_begin; x < x_end; ++x) {
    const int i = x * GROUPS;
    const vec east = x + 1 < nx ? in[i + GROUPS] : (vec)(0);
    const vec value = gx[x] * (here - west) + gx[x + 1] * (here - east) +
                      gy[x] * (here - (has_south ? in[i - south] : (vec)(0))) +
                      gy[x + nx] * (here - (has_north ? in[i + north] : (vec)(0))) +
                      gz[x] * (here - (has_down ? in[i - down] : (vec)(0))) +
                      gz[x + nx * ny] * (here - (has_up ? in[i + up] : (vec)(0))) + sink[x] * here;
    out[i] = value;
    sum += to_accu(value) * to_accu(here);
    west = here;
    here = east;
  }
  partial[(row * segments + segment) * GROUPS + group] = sum;
}

// r = b − A (x + d) with differences and sums in ACCU, and per segment Σ r² and Σ b²
// [row][segment][GROUPS]. Without with_d, d is taken for zero.
kernel void residual_accurate(LEVEL_ARGUMENTS, global const REAL* restrict sink, const int with_d,
                              global const vec* restrict in, global const vec* restrict d,
                              global const vec* restrict rhs, global vec* restrict out,
                              global accu_vec* restrict sum_rr, global accu_vec* restrict sum_bb) {
  ROW_SETUP
  sink += (size_t)row * nx;
  in += first;
  d += first;
  rhs += first;
  out += first;
  accu_vec rr = (accu_vec)(0), bb = (accu_vec)(0);
#define AT(i) (with_d ? to_accu(in[i]) + to_accu(d[i]) : to_accu(in[i]))
  accu_vec west = x_begin > 0 ? AT((x_begin - 1) * GROUPS) : (accu_vec)(0);
  accu_vec here = AT(x_begin * GROUPS);
  for (int x = x_begin; x < x_end; ++x) {
    const int i = x * GROUPS;
    const accu_vec east = x + 1 < nx ? AT(i + GROUPS) : (accu_vec)(0);
    const accu_vec value = (ACCU)gx[x] * (here - west) + (ACCU)gx[x + 1] * (here - east) +
                           (ACCU)gy[x] * (here - (has_south ? AT(i - south) : (accu_vec)(0))) +
                           (ACCU)gy[x + nx] * (here - (has_north ? AT(i + north) : (accu_vec)(0))) +
                           (ACCU)gz[x] * (here - (has_down ? AT(i - down) : (accu_vec)(0))) +
                           (ACCU)gz[x + nx * ny] * (here - (has_up ? AT(i + up) : (accu_vec)(0))) +
                           (ACCU)sink[x] * here;
    const accu_vec right = to_accu(rhs[i]);
    const accu_vec difference = right - value;
    out[i] = to_vec(difference);
    rr += difference * difference;
    bb += right * right;
    west = here;
    here = east;
  }
#undef AT
  sum_rr[(row * segments + segment) * GROUPS + group] = rr;
  sum_bb[(row * segments + segment) * GROUPS + group] = bb;
}

// From φ = 0: φ = f / D on cells of `colour` = (x+y+z) mod 2.
kernel void smooth_from_zero(LEVEL_ARGUMENTS, global const REAL* restrict smoother,
                             const int colour, global vec* restrict phi,
                             global const vec* restrict rhs) {
  ROW_SETUP
  smoother += (size_t)row * nx;
  phi += first;
  rhs += first;
  for (int x = x_begin + ((colour ^ x_begin ^ y ^ z) & 1); x < x_end; x += 2) {
    phi[x * GROUPS] = smoother[x] * rhs[x * GROUPS];
  }
}

// φ = smoother (f + Σ G φ_neighbour) on cells of one colour; all neighbours have the other, so the
// order within a colour does not matter. On black cells that solves; on red ones it is a sweep from
// φ = 0.
kernel void smooth(LEVEL_ARGUMENTS, global const REAL* restrict smoother, const int colour,
                   global vec* restrict phi, global const vec* restrict rhs) {
  ROW_SETUP
  smoother += (size_t)row * nx;
  phi += first;
  rhs += first;
  for (int x = x_begin + ((colour ^ x_begin ^ y ^ z) & 1); x < x_end; x += 2) {
    const int i = x * GROUPS;
    const vec west = x > 0 ? phi[i - GROUPS] : (vec)(0);
    const vec east = x + 1 < nx ? phi[i + GROUPS] : (vec)(0);
    const vec inflow = gx[x] * west + gx[x + 1] * east +
                       gy[x] * (has_south ? phi[i - south] : (vec)(0)) +
                       gy[x + nx] * (has_north ? phi[i + north] : (vec)(0)) +
                       gz[x] * (has_down ? phi[i - down] : (vec)(0)) +
                       gz[x + nx * ny] * (has_up ? phi[i + up] : (vec)(0));
    phi[i] = smoother[x] * (rhs[i] + inflow);
  }
}

// f − A φ of cell x.
#define RESIDUAL(here)                                                        \
  (rhs[i] - (gx[x] * (here - (x > 0 ? phi[i - GROUPS] : (vec)(0))) +          \
             gx[x + 1] * (here - (x + 1 < nx ? phi[i + GROUPS] : (vec)(0))) + \
             gy[x] * (here - (has_south ? phi[i - south] : (vec)(0))) +       \
             gy[x + nx] * (here - (has_north ? phi[i + north] : (vec)(0))) +  \
             gz[x] * (here - (has_down ? phi[i - down] : (vec)(0))) +         \
             gz[x + nx * ny] * (here - (has_up ? phi[i + up] : (vec)(0))) + sink[x] * here))

// The residual on cells of `colour`, where the other colour is solved and has none: the reduced
// system's.
kernel void residual_of_colour(LEVEL_ARGUMENTS, global const REAL* restrict sink, const int colour,
                               global const vec* restrict phi, global const vec* restrict rhs,
                               global vec* restrict out) {
  ROW_SETUP
  sink += (size_t)row * nx;
  phi += first;
  rhs += first;
  out += first;
  for (int x = x_begin + ((colour ^ x_begin ^ y ^ z) & 1); x < x_end; x += 2) {
    const int i = x * GROUPS;
    const vec here = phi[i];
    out[i] = RESIDUAL(here);
  }
}

// φ += smoother × residual on cells of `colour`: damped Jacobi on the reduced system where the
// other colour is solved.
kernel void relax(LEVEL_ARGUMENTS, global const REAL* restrict sink,
                  global const REAL* restrict smoother, const int colour, global vec* restrict phi,
                  global const vec* restrict rhs) {
  ROW_SETUP
  sink += (size_t)row * nx;
  smoother += (size_t)row * nx;
  phi += first;
  rhs += first;
  for (int x = x_begin + ((colour ^ x_begin ^ y ^ z) & 1); x < x_end; x += 2) {
    const int i = x * GROUPS;
    const vec here = phi[i];
    phi[i] = here + smoother[x] * RESIDUAL(here);
  }
}
