// What OpenCL files of solvers for several lights at once begin with (cmake/EmbedKernels.cmake puts
// it there). Fields are [row] vectors of WIDTH lanes of REAL, a lane per light. OWN: 1 where every
// lane has a medium of its own, 0 where all share one; numbers of the medium are `own`. All -D names
// have defaults, so that each file compiles by itself.
#ifndef REAL
#define REAL float
#endif
#ifndef WIDTH
#define WIDTH 16  // 1, 2, 4, 8 or 16
#endif
#ifndef OWN
#define OWN 1
#endif
#ifndef INTERLEAVED
#define INTERLEAVED 0
#endif

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#if WIDTH == 1
#define LANES_OF(type) type
#else
#define LANES_OF(type) JOIN(type, WIDTH)
#endif
#define TO(type) JOIN(convert_, LANES_OF(type))
typedef LANES_OF(REAL) vec;
#if OWN
typedef vec own;
#else
typedef REAL own;
#endif

#define ITEM(count)                    \
  const int i = (int)get_global_id(0); \
  if (i >= count) return;

// Where the scalars of conjugate gradients stand, [place][lane] (Place in device_lanes.h): the size of
// the residual, r·z and the one before, what the former direction and then the direction are taken
// times, and the residual's length.
#define CG_SIZE 0
#define CG_R_Z 1
#define CG_BEFORE 2
#define CG_ALONG 3
#define CG_STEP 4
#define CG_LENGTH 5

// Sums run over `runs` stretches, whose sums sums.cl adds. INTERLEAVED: 1 where their items take turns
// row by row (GPUs).
#define RUN(rows)                                     \
  const int run = (int)get_global_id(0);              \
  if (run >= runs) return;                            \
  const int length = (rows - 1) / runs + 1;           \
  const int begin = INTERLEAVED ? run : run * length; \
  const int step_over = INTERLEAVED ? runs : 1;       \
  const int end = INTERLEAVED ? rows : min(begin + length, rows);
