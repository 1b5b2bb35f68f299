// A field on voxels of twice the edge, carried over linearly between centres: of the eight coarse
// cells around a fine one the nearer has three quarters of the weight along every axis. Beyond the
// rim the outermost cell goes on.

// Lanes of a coarse cell, which has `lanes`, from the lane `from` on.
vec coarse_lanes(global const REAL* restrict coarse, const size_t cell, const int lanes,
                 const int from) {
#if WIDTH == 1
  return coarse[cell * lanes + from];
#else
  return JOIN(vload, WIDTH)(0, coarse + cell * lanes + from);
#endif
}

// φ of cx × cy × cz coarse cells of `lanes` lanes, to nx × ny × nz fine ones of LANES, which are
// the coarse lanes from `from` on.
kernel void interpolate(const int nx, const int ny, const int nz, const int cx, const int cy,
                        const int cz, const int lanes, const int from,
                        global const REAL* restrict coarse, global vec* restrict fine) {
  FOR_ROW
  const int y = row % ny, z = row / ny, lane = from + group * WIDTH;
  const int y0 = y / 2, z0 = z / 2;
  const int y1 = clamp(y % 2 ? y0 + 1 : y0 - 1, 0, cy - 1);
  const int z1 = clamp(z % 2 ? z0 + 1 : z0 - 1, 0, cz - 1);
  const size_t rows[4] = {(size_t)cx * (y0 + (size_t)cy * z0), (size_t)cx * (y1 + (size_t)cy * z0),
                          (size_t)cx * (y0 + (size_t)cy * z1), (size_t)cx * (y1 + (size_t)cy * z1)};
  for (int x = begin; x < end; ++x) {
    const int x0 = x / 2, x1 = clamp(x % 2 ? x0 + 1 : x0 - 1, 0, cx - 1);
    vec across[4];
    for (int k = 0; k < 4; ++k) {
      across[k] = (REAL)0.75 * coarse_lanes(coarse, rows[k] + x0, lanes, lane) +
                  (REAL)0.25 * coarse_lanes(coarse, rows[k] + x1, lanes, lane);
    }
    fine[((size_t)row * nx + x) * GROUPS + group] =
        (REAL)0.75 * ((REAL)0.75 * across[0] + (REAL)0.25 * across[1]) +
        (REAL)0.25 * ((REAL)0.75 * across[2] + (REAL)0.25 * across[3]);
  }
}
