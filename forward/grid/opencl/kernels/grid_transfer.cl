// Transfer between a fine grid level and the next coarser one, on a batch of fields.
//
// A coarse cell X holds fine cells 2X and, where it exists, 2X+1 along every axis. Interpolation is
// cell-centred and conductance-weighted, a product over the axes: along x, fine cell i of coarse
// cell I next to coarse cell J takes
//
//     (1 − w) φ_I + w φ_J,   w = R(I's node, i) / R(I's node, J's node),   R = resistance
//
//          I             J
//     |  o  I  i  |  j  J  o  |         uniform κ: w = 1/4
//
// The node of a coarse cell lies between its children, nearer to the one with more conductance
// around it (grid_coarsen.cl),
// so that flux, not value, runs on through jumps of κ. Restriction is the transpose. Values outside
// the block are 0. Only fine cells of one colour (x+y+z) mod 2 take part: the residual of the other
// colour is zero, and what it would receive is overwritten by the smoother.
//
// An axis that is not halved, half_x = 0, has coarse cell X = x and weight 0.
//
// Fields are [z][y][x][GROUPS] vectors; weights wx, wy, wz are [z][y][x] on the fine level.
// coarse = Pᵀ residual. Items as in grid_operator.cl, over the coarse grid.
//
// A coarse row gathers from the 16 or fewer fine rows around it. Red cells of one fine row share
// the parity of x, so each has its parent and one neighbour of it to give to: with x = 2k + odd,
//
//     out[X] += own_X + across_(X+1)   (odd = 0)      out[X] += own_X + across_(X−1)   (odd = 1)

kernel void restrict_residual(const int nx, const int ny, const int nz, const int cx, const int cy,
                              const int cz, const int colour, const int half_x, const int half_y,
                              const int half_z, global const REAL* restrict wx,
                              global const REAL* restrict wy, global const REAL* restrict wz,
                              global const vec* restrict residual, global vec* restrict coarse) {
  const int group = (int)get_global_id(0) % GROUPS;
  const int begin = (int)get_global_id(0) / GROUPS * SEGMENT;
  const int row = (int)get_global_id(1);
  if (begin >= cx || row >= cy * cz) return;
  const int end = min(cx, begin + SEGMENT);
  const int cell_y = row % cy, cell_z = row / cy;
  coarse += (size_t)row * cx * GROUPS + group;
  for (int cell_x = begin; cell_x < end; ++cell_x) coarse[cell_x * GROUPS] = (vec)(0);

  const int z_begin = max((cell_z << half_z) - half_z, 0),
            z_end = min(((cell_z + 1) << half_z) + half_z, nz);
  const int y_begin = max((cell_y << half_y) - half_y, 0),
            y_end = min(((cell_y + 1) << half_y) + half_y, ny);
  for (int z = z_begin; z < z_end; ++z) {
    // own: 1 − w = 1 + (−1) w; across: w = 0 + 1 w
    const REAL z_at_0 = (z >> half_z) == cell_z, z_slope = 1 - 2 * z_at_0;
    for (int y = y_begin; y < y_end; ++y) {
      const REAL y_at_0 = (y >> half_y) == cell_y, y_slope = 1 - 2 * y_at_0;
      const int odd = (colour ^ y ^ z) & 1;
      const size_t fine = ((size_t)z * ny + y) * nx;
      if (!half_x) {
        for (int x = begin + ((colour ^ begin ^ y ^ z) & 1); x < end; x += 2) {
          const size_t i = fine + x;
          coarse[x * GROUPS] += ((y_at_0 + y_slope * wy[i]) * (z_at_0 + z_slope * wz[i])) *
                                residual[i * GROUPS + group];
        }
        continue;
      }
      // From the fine cell with x = 2k + odd on: what it gives to its parent's neighbour.
      const int first = odd ? begin - 1 : begin;
      const int last = odd ? end : min(end + 1, cx);
      vec own_before = (vec)(0), across_before = (vec)(0);
      for (int k = max(first, 0); k < last; ++k) {
        const int x = 2 * k + odd;
        vec own = (vec)(0), across = (vec)(0);
        if (x < nx) {
          const size_t i = fine + x;
          const vec given = ((y_at_0 + y_slope * wy[i]) * (z_at_0 + z_slope * wz[i])) *
                            residual[i * GROUPS + group];
          across = wx[i] * given;
          own = given - across;
        }
        if (odd) {
          if (k >= begin) coarse[k * GROUPS] += own + across_before;
        } else if (k > begin) {
          coarse[(k - 1) * GROUPS] += own_before + across;
        }
        own_before = own;
        across_before = across;
      }
      if (!odd && last == end) coarse[(end - 1) * GROUPS] += own_before;
    }
  }
}

// φ += P coarse on fine cells of one colour. Items as in
// grid_operator.cl, over the fine grid.
kernel void prolong_add(const int nx, const int ny, const int nz, const int cx, const int cy,
                        const int cz, const int colour, const int half_x, const int half_y,
                        const int half_z, global const REAL* restrict wx,
                        global const REAL* restrict wy, global const REAL* restrict wz,
                        global const vec* restrict coarse, global vec* restrict phi) {
  const int group = (int)get_global_id(0) % GROUPS;
  const int begin = (int)get_global_id(0) / GROUPS * SEGMENT;
  const int row = (int)get_global_id(1);
  if (begin >= nx || row >= ny * nz) return;
  const int end = min(nx, begin + SEGMENT);
  const int y = row % ny, z = row / ny;
  // Own parents and those across; where there is none the weight is made zero.
  const int y_across = (y >> half_y) + ((y & 1) ? 1 : -1);
  const int z_across = (z >> half_z) + ((z & 1) ? 1 : -1);
  const int has_y = half_y && y_across >= 0 && y_across < cy;
  const int has_z = half_z && z_across >= 0 && z_across < cz;
  const int own_y = (y >> half_y) * cx, own_z = (z >> half_z) * cx * cy;
  const int far_y = has_y ? y_across * cx : own_y, far_z = has_z ? z_across * cx * cy : own_z;
  global const vec* restrict oo = coarse + (size_t)(own_y + own_z) * GROUPS + group;
  global const vec* restrict fo = coarse + (size_t)(far_y + own_z) * GROUPS + group;
  global const vec* restrict of = coarse + (size_t)(own_y + far_z) * GROUPS + group;
  global const vec* restrict ff = coarse + (size_t)(far_y + far_z) * GROUPS + group;
  for (int x = begin + ((colour ^ begin ^ y ^ z) & 1); x < end; x += 2) {
    const int i = row * nx + x;
    const REAL ty = wy[i], tz = wz[i], tx = wx[i];
    const REAL w_oo = (1 - ty) * (1 - tz), w_fo = has_y * ty * (1 - tz);
    const REAL w_of = has_z * (1 - ty) * tz, w_ff = has_y * has_z * ty * tz;
    const int own = (x >> half_x) * GROUPS;
    const int x_across = (x >> half_x) + ((x & 1) ? 1 : -1);
    vec sum = (1 - tx) * (w_oo * oo[own] + w_fo * fo[own] + w_of * of[own] + w_ff * ff[own]);
    if (half_x && x_across >= 0 && x_across < cx) {
      const int far = x_across * GROUPS;
      sum += tx * (w_oo * oo[far] + w_fo * fo[far] + w_of * of[far] + w_ff * ff[far]);
    }
    phi[(size_t)i * GROUPS + group] += sum;
  }
}
