// The V-cycle of flat steps (grid_flat_prelude.cl) on the reduced system of each level, whose
// right-hand side is r' = r_r + Σ G r_b / D, and r itself on the finest level, where r_b = 0. Way
// down: φ_r = T r', black cells solved for, residual, restriction. Way up: φ_r = T r' + P coarse,
// black, red relaxed, black.

// r_r += Σ G r_b / D, in place.
FLAT void reduce(GRID_ARGUMENTS, global const REAL* restrict smoother, global vec* rhs) {
  FOR_PLACES {
    PLACE(RED)
    global const vec* black = rhs + (size_t)places * GROUPS;
#define SOLVED(place, cell) (smoother[cell] * black[AT(place)])
    const Neighbours at = NEIGHBOURS(SOLVED);
    rhs[AT(place)] += inflow(STENCIL, at);
#undef SOLVED
  }
}

// φ_b = Σ G φ_r / D with φ_r = T r'.
FLAT void solve_black_first(GRID_ARGUMENTS, global const REAL* restrict smoother,
                            global const vec* restrict rhs, global vec* restrict solution) {
  FOR_PLACES {
    PLACE(BLACK)
#define FIRST(place, cell) (smoother[cell] * rhs[AT(place)])
    const Neighbours at = NEIGHBOURS(FIRST);
#undef FIRST
    const Stencil g = STENCIL;
    solution[AT(places + place)] = g.smoother * inflow(g, at);
  }
}

#define BLACK_VALUE(place, cell) black[AT(place)]

// r' − S φ_r with φ_r = T r' and black cells solved for.
FLAT void residual_of_first(GRID_ARGUMENTS, global const vec* restrict rhs,
                            global const vec* restrict solution, global vec* restrict residual) {
  FOR_PLACES {
    PLACE(RED)
    global const vec* black = solution + (size_t)places * GROUPS;
    const Neighbours at = NEIGHBOURS(BLACK_VALUE);
    const Stencil g = STENCIL;
    const vec right = rhs[AT(place)];
    residual[AT(place)] = right - image(g, g.smoother * right, at);
  }
}

// φ_b = (r_b + Σ G φ_r) / D; without with_rhs r_b = 0.
FLAT void solve_black(GRID_ARGUMENTS, const int with_rhs, global const vec* restrict rhs,
                      global vec* solution) {
  FOR_PLACES {
    PLACE(BLACK)
#define RED_VALUE(place, cell) solution[AT(place)]
    const Neighbours at = NEIGHBOURS(RED_VALUE);
#undef RED_VALUE
    const Stencil g = STENCIL;
    const vec flow = inflow(g, at);
    solution[AT(places + place)] = g.smoother * (with_rhs ? rhs[AT(places + place)] + flow : flow);
  }
}

// φ_r += T (r' − S φ_r) where black cells are solved for.
#define RELAX(here, right)                                               \
  global const vec* black = solution + (size_t)places * GROUPS;          \
  const Neighbours at = NEIGHBOURS(BLACK_VALUE);                         \
  const Stencil g = STENCIL;                                             \
  const vec right = rhs[AT(place)], before = solution[AT(place)];        \
  const vec here = before + g.smoother * (right - image(g, before, at)); \
  solution[AT(place)] = here;

FLAT void relax(GRID_ARGUMENTS, global const vec* restrict rhs, global vec* solution) {
  FOR_PLACES {
    PLACE(RED)
    RELAX(here, right)
  }
}

// The same, and partial sums of φ r'.
FLAT void relax_and_sum(GRID_ARGUMENTS, global const vec* restrict rhs, global vec* solution,
                        global accu_vec* restrict partial) {
  SUM(sum);
  FOR_PLACES {
    PLACE(RED)
    RELAX(here, right)
    sum += to_accu(here) * to_accu(right);
  }
  LEAVE_SUM(sum, partial);
}

#define TRANSFER_ARGUMENTS                                                            \
  const int nx, const int ny, const int nz, const int cx, const int cy, const int cz, \
      const int half_x, const int half_y, const int half_z, global const Weights *restrict weights

// Of cell (x, y, z) of the coarse grid among vectors held by colour.
INLINE size_t coarse_place(int x, int y, int z, int cx, int cy, int cz) {
  const int colour = (x ^ y ^ z) & 1, pairs = (cx + 1) >> 1;
  return ((size_t)(colour * cz + z) * cy + y) * pairs + (x >> 1);
}

// coarse = Pᵀ residual, an item per coarse cell: what it takes of the red cells in it and, along
// halved axes, next to it.
FLAT void restrict_residual(TRANSFER_ARGUMENTS, global const vec* restrict residual,
                            global vec* restrict coarse) {
  const int group = (int)get_global_id(0) % GROUPS, slot = (int)get_global_id(0) / GROUPS;
  const int tile = slot >> 6, tiles_x = (cx + 7) >> 3, tiles_y = (cy + 3) >> 2;
  const int X = ((tile % tiles_x) << 3) + (slot & 7),
            Y = ((tile / tiles_x % tiles_y) << 2) + (slot >> 3 & 3),
            Z = ((tile / tiles_x / tiles_y) << 1) + (slot >> 5 & 1);
  if (X >= cx || Y >= cy || Z >= cz) return;
  const int x_begin = max((X << half_x) - half_x, 0), x_end = min(((X + 1) << half_x) + half_x, nx);
  const int y_begin = max((Y << half_y) - half_y, 0), y_end = min(((Y + 1) << half_y) + half_y, ny);
  const int z_begin = max((Z << half_z) - half_z, 0), z_end = min(((Z + 1) << half_z) + half_z, nz);
  vec sum = (vec)(0);
  for (int z = z_begin; z < z_end; ++z) {
    // The share of a cell's own parent is 1 − w, that of the one across w.
    const REAL z_at_0 = z >> half_z == Z, z_slope = 1 - 2 * z_at_0;
    for (int y = y_begin; y < y_end; ++y) {
      const REAL y_at_0 = y >> half_y == Y, y_slope = 1 - 2 * y_at_0;
      const int row = (int)RED_ROW(y, z);
      // Two red cells at most, fetched together.
      const int x = x_begin + PARITY(x_begin, y, z), next = x + 2;
#define GIVEN(at)                                                          \
  {                                                                        \
    const int from = row + ((at) >> 1);                                    \
    const Weights w = weights[from];                                       \
    const REAL x_at_0 = (at) >> half_x == X;                               \
    sum += ((x_at_0 + (1 - 2 * x_at_0) * w.x) * (y_at_0 + y_slope * w.y) * \
            (z_at_0 + z_slope * w.z)) *                                    \
           residual[AT(from)];                                             \
  }
      if (x < x_end) GIVEN(x)
      if (next < x_end) GIVEN(next)
#undef GIVEN
    }
  }
  coarse[AT(coarse_place(X, Y, Z, cx, cy, cz))] = sum;
}

// φ_r = T r' + P coarse.
FLAT void correct_first(GRID_ARGUMENTS, const int cx, const int cy, const int cz, const int half_x,
                        const int half_y, const int half_z, global const Weights* restrict weights,
                        global const vec* restrict rhs, global const vec* restrict coarse,
                        global vec* restrict solution) {
  FOR_PLACES {
    PLACE(RED)
    const Weights w = weights[place];
    // The parent, and its neighbours on this cell's side, where there are any.
    const int X = x >> half_x, Y = y >> half_y, Z = z >> half_z;
    const int side_x = X + 2 * (x & 1) - 1, side_y = Y + 2 * (y & 1) - 1,
              side_z = Z + 2 * (z & 1) - 1;
    const int far_x = half_x && side_x >= 0 && side_x < cx ? side_x : X,
              far_y = half_y && side_y >= 0 && side_y < cy ? side_y : Y,
              far_z = half_z && side_z >= 0 && side_z < cz ? side_z : Z;
    const REAL to_x = far_x == X ? 0 : w.x, to_y = far_y == Y ? 0 : w.y,
               to_z = far_z == Z ? 0 : w.z;
#define COARSE(x, y, z) coarse[AT(coarse_place(x, y, z, cx, cy, cz))]
#define ALONG_X(y, z) ((1 - w.x) * COARSE(X, y, z) + to_x * COARSE(far_x, y, z))
    const vec correction = (1 - w.z) * ((1 - w.y) * ALONG_X(Y, Z) + to_y * ALONG_X(far_y, Z)) +
                           to_z * ((1 - w.y) * ALONG_X(Y, far_z) + to_y * ALONG_X(far_y, far_z));
#undef ALONG_X
#undef COARSE
    solution[AT(place)] = STENCIL.smoother * rhs[AT(place)] + correction;
  }
}

// The last level by the inverse of its matrix, [place][place] of both colours; 0 where no cell is.
FLAT void solve_last(const int places, global const REAL* restrict inverse,
                     global const vec* restrict rhs, global vec* restrict solution) {
  const int group = (int)get_global_id(0) % GROUPS, place = (int)get_global_id(0) / GROUPS;
  if (place >= places) return;
  vec sum = (vec)(0);
#pragma unroll 8
  for (int k = 0; k < places; ++k) {
    const REAL part = inverse[k * places + place];
    sum += part == 0 ? (vec)(0) : part * rhs[AT(k)];
  }
  solution[AT(place)] = sum;
}
#undef RELAX
#undef BLACK_VALUE
