// Cells by colour, their stencils, and where both stand: shared by stream and flat steps.

// Helpers must be inlined: only then does the compiler use vectors of full width everywhere.
#define INLINE inline __attribute__((always_inline))

// What the cycle needs of a cell, in one place (pack_stencils in grid_assemble.cl): its faces'
// conductances, what solves or relaxes it and its sink. Of a row, cells with even x come first.
typedef struct {
  REAL west, east, south, north, down, up, smoother, sink;
} Stencil;

// And the weights of interpolation, of red cells only: black ones are solved for. A coarse cell X
// holds fine cells 2X and, where it exists, 2X+1 along every axis that is halved. Interpolation is
// cell-centred and conductance-weighted, a product over the axes: along x, fine cell i of coarse
// cell I next to coarse cell J takes
//
//     (1 − w) φ_I + w φ_J,   w = R(I's node, i) / R(I's node, J's node),   R = resistance
//
//          I             J
//     |  o  I  i  |  j  J  o  |         uniform κ: w = 1/4
//
// The node of a coarse cell lies between its children, nearer to the one with more conductance
// around it (grid_coarsen.cl), so that flux, not value, runs on through jumps of κ. Restriction is
// the transpose. Values outside the block are 0. An axis that is not halved, half_x = 0, has coarse
// cell X = x and weight 0.
typedef struct {
  REAL x, y, z;
} Weights;

#define RED 0
#define BLACK 1
// x mod 2 of the cells of a colour in row (y, z).
#define PARITY(colour, y, z) (((colour) ^ (y) ^ (z)) & 1)

// Index of cell x of row (y, z), of the first red cell of a row among red ones, of the first cell
// of one parity among stencils.
#define CELL(x, y, z) (((size_t)(z)*ny + (y)) * nx + (x))
#define HALF ((nx + 1) >> 1)
#define RED_ROW(y, z) (((size_t)(z)*ny + (y)) * HALF)
#define STENCIL_ROW(y, z, parity) ((((size_t)(z)*ny + (y)) * 2 + (parity)) * HALF)

#define GRID_ARGUMENTS \
  const int nx, const int ny, const int nz, global const Stencil *restrict stencils
