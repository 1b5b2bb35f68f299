// The operator of one grid level on a batch of fields.
//
//   (A φ)_i = Σ_faces G (φ_i − φ_neighbour) + S_i φ_i,     φ_neighbour = 0 outside the block
//
// in flux form: differences first, so that float keeps the small absorption S = μ h³ that the sum
// of a stored diagonal would round away.
//
// Layout. A field is [z][y][x][GROUPS] vectors of WIDTH patterns. Face conductances include the
// boundary faces (0 on mirrors). While levels are set up they are gx [nz][ny][nx+1], gy
// [nz][ny+1][nx] and gz [nz+1][ny][nx], afterwards parts of the stencils; gx[x] lies between cells
// x−1 and x:
//
//        gx[0]     gx[1]     gx[2]              gx[nx]
//          |  x=0    |  x=1    |      ...          |

// y = A x.
kernel void apply(GRID_ARGUMENTS, global const vec* restrict in, global vec* restrict out) {
  FOR_ROW
  const int y = row % ny, z = row / ny;
  const int south = nx * GROUPS, down = nx * ny * GROUPS;
  in += (size_t)row * nx * GROUPS + group;
  out += (size_t)row * nx * GROUPS + group;
  for (int x = begin; x < end; ++x) {
    const Stencil g = stencils[STENCIL_ROW(y, z, x & 1) + (x >> 1)];
    const int i = x * GROUPS;
    const vec here = in[i];
    out[i] = g.west * (here - (x > 0 ? in[i - GROUPS] : (vec)(0))) +
             g.east * (here - (x + 1 < nx ? in[i + GROUPS] : (vec)(0))) +
             g.south * (here - (y > 0 ? in[i - south] : (vec)(0))) +
             g.north * (here - (y + 1 < ny ? in[i + south] : (vec)(0))) +
             g.down * (here - (z > 0 ? in[i - down] : (vec)(0))) +
             g.up * (here - (z + 1 < nz ? in[i + down] : (vec)(0))) + g.sink * here;
  }
}
