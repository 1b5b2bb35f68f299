// Fields of a block as lateral waves, and their coordinates (lateral_modes.h, basis.h).
#define TILE 64
#define DEPTH 16
#define SIDE 16
#define EACH (TILE / SIDE)

// Where value k along an axis, of place `other` on the other lateral axis and of a row of
// coefficients, is found.
typedef struct {
  int axis, other, depth, step, jump;
} Place;

size_t place_of(const Place p, const int k, const int other, const int row) {
  return (size_t)k * p.axis + (size_t)other * p.other + (size_t)(row % p.depth) * p.step +
         (size_t)(row / p.depth) * p.jump;
}

// The product of a matrix [n][n], given by its rows or, transposed, by its columns, with all lines
// along one axis: others × rows of them. Work-groups make tiles of 64 × 64 products; the dense
// product costs 2n flops a value and axis and is one for any n.
kernel __attribute__((reqd_work_group_size(SIDE, SIDE, 1))) void along_axis(
    const int n, const int others, const int rows, const int transposed,
    global const double* restrict matrix, const int from_axis, const int from_other,
    const int from_depth, const int from_step, const int from_jump, const int to_axis,
    const int to_other, const int to_depth, const int to_step, const int to_jump,
    global const double* restrict from, global double* restrict to) {
  local double left[TILE][DEPTH + 1], right[DEPTH][TILE + 1];
  const Place source = {from_axis, from_other, from_depth, from_step, from_jump};
  const Place target = {to_axis, to_other, to_depth, to_step, to_jump};
  const int x = (int)get_local_id(0), y = (int)get_local_id(1), item = y * SIDE + x;
  const int lines = others * rows;
  const int first_line = (int)get_group_id(0) * TILE, first_k = (int)get_group_id(1) * TILE;
  // Neighbouring items write to neighbouring places.
  const int my_k = to_axis == 1 ? x : y, my_line = to_axis == 1 ? y : x;
  double sum[EACH][EACH];
  for (int a = 0; a < EACH; ++a) {
    for (int b = 0; b < EACH; ++b) sum[a][b] = 0;
  }
  for (int start = 0; start < n; start += DEPTH) {
    for (int e = item; e < TILE * DEPTH; e += SIDE * SIDE) {
      const int k = transposed ? e % TILE : e / DEPTH, i = transposed ? e / TILE : e % DEPTH;
      const int row = first_k + k, column = start + i;
      left[k][i] = row < n && column < n
                       ? matrix[transposed ? (size_t)column * n + row : (size_t)row * n + column]
                       : 0;
    }
    for (int e = item; e < TILE * DEPTH; e += SIDE * SIDE) {
      const int l = from_axis == 1 ? e / DEPTH : e % TILE,
                i = from_axis == 1 ? e % DEPTH : e / TILE;
      const int line = first_line + l, value = start + i;
      right[i][l] = line < lines && value < n
                        ? from[place_of(source, value, line % others, line / others)]
                        : 0;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int i = 0; i < DEPTH; ++i) {
      for (int a = 0; a < EACH; ++a) {
        for (int b = 0; b < EACH; ++b) {
          sum[a][b] += left[my_k + a * SIDE][i] * right[i][my_line + b * SIDE];
        }
      }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  for (int a = 0; a < EACH; ++a) {
    for (int b = 0; b < EACH; ++b) {
      const int k = first_k + my_k + a * SIDE, line = first_line + my_line + b * SIDE;
      if (k < n && line < lines) to[place_of(target, k, line % others, line / others)] = sum[a][b];
    }
  }
}

// Each wave's coefficients [wave][row] times the triangular matrix [column][row] of its bin: upper,
// or lower where it is one's transpose. One item per coefficient.
kernel void by_bins(const int waves, const int rows, const int upper,
                    global const int* restrict bin, global const double* restrict matrices,
                    global const double* restrict from, global double* restrict to) {
  const size_t i = get_global_id(0);
  if (i >= (size_t)waves * rows) return;
  const int row = (int)(i % rows);
  const size_t wave = i / rows;
  matrices += (size_t)bin[wave] * rows * rows;
  from += wave * rows;
  double sum = 0;
  for (int c = upper ? row : 0; c < (upper ? rows : row + 1); ++c) {
    sum += matrices[(size_t)c * rows + row] * from[c];
  }
  to[i] = sum;
}
