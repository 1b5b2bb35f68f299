// What every OpenCL file of the grid solver begins with (cmake/EmbedKernels.cmake puts it there):
// number types and how many patterns a work-item holds. Fields are [z][y][x][GROUPS] vectors of
// WIDTH patterns. All -D names have defaults, so that each file compiles by itself.
#ifndef ACCU
#define ACCU double  // sums and residuals; float where the device has no double
#endif
#ifndef GROUPS
#define GROUPS 1  // such vectors per cell: lanes = WIDTH * GROUPS
#endif
#ifndef SEGMENT
#define SEGMENT 0x40000000  // cells of a row one item walks: all, or on GPUs a single one
#endif
#define LANES (WIDTH * GROUPS)

// The cells begin <= x < end of a row that belong to an item, and its vector of them: global id 0
// is group + GROUPS segment, 1 is the row y + ny z (LaneKernels::rows).
#define FOR_ROW                                               \
  const int group = (int)get_global_id(0) % GROUPS;           \
  const int begin = (int)get_global_id(0) / GROUPS * SEGMENT; \
  const int row = (int)get_global_id(1);                      \
  if (begin >= nx || row >= ny * nz) return;                  \
  const int end = SEGMENT < nx - begin ? begin + SEGMENT : nx;
// The same for all patterns together: global id 0 is the segment (LaneKernels::scalar_rows). Of
// rows of another length or number: those, and of the item's cells those from `first` on, before
// `last`.
#define FOR_SCALAR_ROW FOR_ROW_OF(nx, ny* nz)
#define FOR_ROW_OF(cells, rows)                      \
  const int begin = (int)get_global_id(0) * SEGMENT; \
  const int row = (int)get_global_id(1);             \
  if (begin >= (cells) || row >= (rows)) return;     \
  const int end = SEGMENT < (cells)-begin ? begin + SEGMENT : (cells);
#define FOR_CELLS(x, first, last) for (int x = max(begin, first); x < min(end, last); ++x)

typedef LANES_OF(ACCU) accu_vec;
#define to_vec(v) TO(REAL)(v)
#define to_accu(v) TO(ACCU)(v)

// Loads ahead of time and stores past the cache, where the compiler knows how. NVIDIA's knows the
// names but not for global memory.
#if defined(__has_builtin) && !defined(__NV_CL_C_VERSION) && !defined(__NVPTX__)
#if __has_builtin(__builtin_prefetch)
#define PREFETCH(address) __builtin_prefetch(address)
#endif
#if __has_builtin(__builtin_nontemporal_store)
#define STREAM_OUT(value, address) __builtin_nontemporal_store(value, address)
#endif
#endif
#ifndef PREFETCH
#define PREFETCH(address)
#endif
#ifndef STREAM_OUT
#define STREAM_OUT(value, address) (*(address) = (value))
#endif

// a / b per lane, 0 where b is not positive: padding lanes and lanes that are solved exactly.
accu_vec ratio(accu_vec a, accu_vec b) {
#if WIDTH == 1
  return b > 0 ? a / b : 0;
#else
  const accu_vec safe = b > (accu_vec)(0) ? b : (accu_vec)(1);
  return b > (accu_vec)(0) ? a / safe : (accu_vec)(0);
#endif
}
