// The reduced system's true residual in ACCU arithmetic (grid_flat_prelude.cl), and with it the way
// back from red cells to all of them. The solution is φ + d: φ on all cells, [z][y][x][GROUPS], and
// d by colour; without with_d, d on red cells is taken for zero.
#define CELL_AT(cell) ((size_t)(cell)*GROUPS + group)

typedef struct {
  accu_vec west, east, south, north, down, up;
} AccurateNeighbours;

// φ + d anew on red cells, as the nearest φ and what that leaves over (Knuth's two-sum).
FLAT void renormalise(GRID_ARGUMENTS, global vec* restrict phi, global vec* restrict d) {
  FOR_PLACES {
    PLACE(RED)
    const vec before = phi[CELL_AT(cell)], more = d[AT(place)];
    const vec high = before + more, shift = high - before;
    d[AT(place)] = (before - (high - shift)) + (more - shift);
    phi[CELL_AT(cell)] = high;
  }
}

// Black cells of φ + d from the red ones.
FLAT void solve_black_accurately(GRID_ARGUMENTS, const int with_d, global const vec* restrict b,
                                 global vec* phi, global vec* d) {
  FOR_PLACES {
    PLACE(BLACK)
#define VALUE(place, cell) \
  (with_d ? to_accu(phi[CELL_AT(cell)]) + to_accu(d[AT(place)]) : to_accu(phi[CELL_AT(cell)]))
    const AccurateNeighbours at = NEIGHBOURS_OR((accu_vec)(0), VALUE);
#undef VALUE
    const Stencil g = STENCIL;
    const accu_vec flow = (ACCU)g.west * at.west + (ACCU)g.east * at.east +
                          (ACCU)g.south * at.south + (ACCU)g.north * at.north +
                          (ACCU)g.down * at.down + (ACCU)g.up * at.up;
    const ACCU diagonal = (ACCU)g.west + (ACCU)g.east + (ACCU)g.south + (ACCU)g.north +
                          (ACCU)g.down + (ACCU)g.up + (ACCU)g.sink;
    const accu_vec here = (to_accu(b[CELL_AT(cell)]) + flow) * (1 / diagonal);
    const vec high = to_vec(here);
    phi[CELL_AT(cell)] = high;
    d[AT(places + place)] = to_vec(here - to_accu(high));
  }
}

// r = b − A (φ + d) on red cells, black ones being solved for; partial sums of r².
FLAT void true_residual(GRID_ARGUMENTS, const int with_d, global const vec* restrict b,
                        global const vec* restrict phi, global const vec* restrict d,
                        global vec* restrict r, global accu_vec* restrict partial) {
  SUM(sum);
  FOR_PLACES {
    PLACE(RED)
    global const vec* black = d + (size_t)places * GROUPS;
#define VALUE(place, cell) (to_accu(phi[CELL_AT(cell)]) + to_accu(black[AT(place)]))
    const AccurateNeighbours at = NEIGHBOURS_OR((accu_vec)(0), VALUE);
#undef VALUE
    const Stencil g = STENCIL;
    accu_vec here = to_accu(phi[CELL_AT(cell)]);
    if (with_d) here += to_accu(d[AT(place)]);
    const accu_vec image = (ACCU)g.west * (here - at.west) + (ACCU)g.east * (here - at.east) +
                           (ACCU)g.south * (here - at.south) + (ACCU)g.north * (here - at.north) +
                           (ACCU)g.down * (here - at.down) + (ACCU)g.up * (here - at.up) +
                           (ACCU)g.sink * here;
    const accu_vec residual = to_accu(b[CELL_AT(cell)]) - image;
    r[AT(place)] = to_vec(residual);
    sum += residual * residual;
  }
  LEAVE_SUM(sum, partial);
}

// The same where φ + d is zero, whatever φ holds: φ_b = b_b / D, r = b_r + Σ G b_b / D.
FLAT void residual_of_zero(GRID_ARGUMENTS, global const REAL* restrict smoother,
                           global const vec* restrict b, global vec* restrict phi,
                           global vec* restrict r, global accu_vec* restrict partial) {
  SUM(sum);
#define SOLVED(place, cell) (smoother[cell] * b[CELL_AT(cell)])
  {
    FOR_PLACES {
      PLACE(BLACK) phi[CELL_AT(cell)] = SOLVED(place, cell);
    }
  }
  FOR_PLACES {
    PLACE(RED)
    phi[CELL_AT(cell)] = (vec)(0);
    const Neighbours at = NEIGHBOURS(SOLVED);
    const accu_vec residual = to_accu(b[CELL_AT(cell)]) + to_accu(inflow(STENCIL, at));
    r[AT(place)] = to_vec(residual);
    sum += residual * residual;
  }
#undef SOLVED
  LEAVE_SUM(sum, partial);
}

// Partial sums of b² over all cells.
FLAT void squares(const int nx, const int ny, const int nz, global const vec* restrict b,
                  global accu_vec* restrict partial) {
  SUM(sum);
  const int group = (int)get_global_id(0) % GROUPS;
  for (int cell = (int)get_global_id(0) / GROUPS; cell < nx * ny * nz;
       cell += (int)get_global_size(0) / GROUPS) {
    const accu_vec value = to_accu(b[CELL_AT(cell)]);
    sum += value * value;
  }
  LEAVE_SUM(sum, partial);
}
