// A step of conjugate gradients on red cells (grid_flat_prelude.cl); every pattern has its own
// scalars, [GROUPS] of ACCU vectors.

// p = z + β p, β = r·z / that before; with `fresh` p = z, whatever it held.
FLAT void next_direction(const int count, const int fresh, global const accu_vec* restrict rz,
                         global const accu_vec* restrict rz_before,
                         global const vec* restrict preconditioned, global vec* restrict p) {
  const int group = (int)get_global_id(0) % GROUPS, place = (int)get_global_id(0) / GROUPS;
  if (place >= count) return;
  const vec z = preconditioned[AT(place)];
  p[AT(place)] = fresh ? z : z + to_vec(ratio(rz[group], rz_before[group])) * p[AT(place)];
}

// Black cells of p, solved for, into its black places, and what that left over by rounding,
// −(A p) / D, into those of `image_of_p`: with it S p keeps the little that weak sinks draw beside
// what strong bonds carry, of which rounding alone takes 6e-8.
FLAT void solve_black_of_direction(GRID_ARGUMENTS, global vec* p, global vec* restrict image_of_p) {
  FOR_PLACES {
    PLACE(BLACK)
#define RED_VALUE(place, cell) p[AT(place)]
    const Neighbours at = NEIGHBOURS(RED_VALUE);
#undef RED_VALUE
    const Stencil g = STENCIL;
    const vec here = g.smoother * inflow(g, at);
    p[AT(places + place)] = here;
    image_of_p[AT(places + place)] = -g.smoother * image(g, here, at);
  }
}

// S p and partial sums of p·S p.
FLAT void image_of_direction(GRID_ARGUMENTS, global const vec* restrict p, global vec* image_of_p,
                             global accu_vec* restrict partial) {
  SUM(sum);
  FOR_PLACES {
    PLACE(RED)

#define BLACK_VALUE(place, cell) p[AT(places + place)]
    const Neighbours at = NEIGHBOURS(BLACK_VALUE);
#undef BLACK_VALUE
#define LEFT_OVER(place, cell) image_of_p[AT(places + place)]
    const Neighbours left = NEIGHBOURS(LEFT_OVER);
#undef LEFT_OVER
    const Stencil g = STENCIL;
    const vec here = p[AT(place)];
    const vec result = image(g, here, at) - inflow(g, left);
    image_of_p[AT(place)] = result;
    sum += to_accu(here) * to_accu(result);
  }
  LEAVE_SUM(sum, partial);
}

// d += α p, r −= α S p with α = r·z / p·Sp; partial sums of r². With first_d d is taken for zero,
// whatever it holds.
FLAT void update(const int nx, const int ny, const int nz, const int first_d,
                 global const accu_vec* restrict rz, global const accu_vec* restrict energy,
                 global const vec* restrict p, global const vec* restrict image_of_p,
                 global vec* restrict d, global vec* restrict r,
                 global accu_vec* restrict partial) {
  SUM(sum);
  FOR_PLACES {
    PLACE(RED)
    const vec alpha = to_vec(ratio(rz[group], energy[group]));
    const vec step = alpha * p[AT(place)];
    d[AT(place)] = first_d ? step : d[AT(place)] + step;
    const vec residual = r[AT(place)] - alpha * image_of_p[AT(place)];
    r[AT(place)] = residual;
    sum += to_accu(residual) * to_accu(residual);
  }
  LEAVE_SUM(sum, partial);
}
