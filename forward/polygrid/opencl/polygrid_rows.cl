// Sparse rows times vectors, and sums over them, which run in a fixed order and are added up in SUM.
//
// Fields, and numbers of media of their own, are [row][lane] without gaps: at three lanes a fourth
// place would be a third more memory.

#ifndef SUM
#define SUM double
#endif

typedef LANES_OF(SUM) sum_vec;

// The lanes of row i.
#if WIDTH == 3
#define LOAD(i, field) vload3(i, field)
#define STORE(lanes, i, field) vstore3(lanes, i, field)
#else
#define LOAD(i, field) (((global const vec*)(field))[i])
#define STORE(lanes, i, field) ((global vec*)(field))[i] = (lanes)
#endif
#if OWN
#define NUMBER(i, numbers) LOAD(i, numbers)
#define SET_NUMBER(number, i, numbers) STORE(number, i, numbers)
#else
#define NUMBER(i, numbers) (numbers)[i]
#define SET_NUMBER(number, i, numbers) (numbers)[i] = (number)
#endif

// Rows beside each other are taken as blocks, their numbers as PARTS vectors of PART. Fields go on
// with zeros to the end of the last block.
#if INTERLEAVED
#define PART WIDTH
#define BLOCK 1
#else
#define PART 16
#if WIDTH == 1 || WIDTH == 3
#define BLOCK 16
#elif WIDTH == 2
#define BLOCK 8
#elif WIDTH == 4
#define BLOCK 4
#elif WIDTH == 8
#define BLOCK 2
#else
#define BLOCK 1
#endif
#endif
#define PARTS (BLOCK * WIDTH / PART)
#define BLOCKS_OF(rows) (((rows)-1) / BLOCK + 1)
#if PART == 1
typedef REAL part;
typedef SUM sum_part;
#define TO_PART(type) JOIN(convert_, type)
#define LOAD_PART(k, from) (from)[k]
#define STORE_PART(numbers, k, to) (to)[k] = (numbers)
#else
typedef JOIN(REAL, PART) part;
typedef JOIN(SUM, PART) sum_part;
#define TO_PART(type) JOIN(convert_, JOIN(type, PART))
#define LOAD_PART(k, from) JOIN(vload, PART)(k, from)
#define STORE_PART(numbers, k, to) JOIN(vstore, PART)(numbers, k, to)
#endif
#if INTERLEAVED
#define AT(k, field) LOAD(k, field)
#define SET(numbers, k, field) STORE(numbers, k, field)
#else
#define AT(k, field) LOAD_PART(k, field)
#define SET(numbers, k, field) STORE_PART(numbers, k, field)
#endif
#define FOR_PARTS(c) for (int c = 0; c < PARTS; ++c)

// Numbers of lanes as a block's.
inline void lanes_to_parts(global const SUM* of_lane, part* to) {
  REAL all[PART * PARTS];
  for (int k = 0; k < PART * PARTS; ++k) all[k] = (REAL)of_lane[k % WIDTH];
  FOR_PARTS(c) to[c] = LOAD_PART(c, all);
}

// partial[at] = Σ by lane of a block's sums, and of single rows'.
inline void leave_sum(const sum_part* of_block, const sum_vec of_rows, const int at,
                      global SUM* restrict partial) {
  SUM all[PART * PARTS];
  FOR_PARTS(c) STORE_PART(of_block[c], c, all);
  for (int k = WIDTH; k < PART * PARTS; ++k) all[k % WIDTH] += all[k];
#if WIDTH == 1
  partial[at] = all[0] + of_rows;
#else
  JOIN(vstore, WIDTH)(JOIN(vload, WIDTH)(0, all) + of_rows, at, partial);
#endif
}

// Three lanes are multiplied as four, the next row's first among them.
#if WIDTH == 3
typedef JOIN(REAL, 4) row_vec;
#define ROW_LANES(field) vload4(0, field)
#define LANES_OF_ROW(lanes) (lanes).xyz
#else
typedef vec row_vec;
#define ROW_LANES(field) LOAD(0, field)
#define LANES_OF_ROW(lanes) (lanes)
#endif
#if OWN
#define NUMBER_WIDTH WIDTH
#define ROW_NUMBER(numbers) ROW_LANES(numbers)
#else
#define NUMBER_WIDTH 1
#define ROW_NUMBER(numbers) (numbers)[0]
#endif
#define ROW(i, field) ((field) + (long)WIDTH * (i))
#define ROW_NUMBERS(i, numbers) ((numbers) + (long)NUMBER_WIDTH * (i))

// Row i of a symmetric matrix of which half is stored, times x (device_numbers.h, DevicePattern).
inline vec row_product(const int i, global const int* restrict list,
                       global const int2* restrict step, global const REAL* restrict value,
                       global const REAL* restrict x) {
  const int place = list[i], end = place + step[place].x;
  global const REAL *numbers = ROW_NUMBERS(i, value), *factors = ROW(i, x);
#define PRODUCT(k) ROW_NUMBER(ROW_NUMBERS(step[k].y, numbers)) * ROW_LANES(ROW(step[k].x, factors))
  // Two sums: in one, additions wait for each other.
  row_vec sum = (row_vec)(0), other = (row_vec)(0);
  int k = place + 1;
  for (; k < end; k += 2) {
    sum += PRODUCT(k);
    other += PRODUCT(k + 1);
  }
  if (k == end) sum += PRODUCT(k);
  return LANES_OF_ROW(sum + other);
}

// The same for a block of rows that share a list, whose numbers are beside each other, too.
#define BLOCKS (!INTERLEAVED && (OWN || WIDTH == 1) && BLOCK > 1)
#if BLOCKS
inline int begins_block(const int i, const int end, global const int* restrict list) {
  return i + BLOCK <= end && all(JOIN(vload, BLOCK)(0, list + i) == (JOIN(int, BLOCK))(list[i]));
}

inline void block_product(const int i, global const int* restrict list,
                          global const int2* restrict step, global const REAL* restrict value,
                          global const REAL* restrict x, part* product) {
  const int place = list[i], end = place + step[place].x;
  part sum[PARTS];
  FOR_PARTS(c) sum[c] = (part)(0);
  for (int k = place + 1; k <= end; ++k) {
    global const REAL *numbers = ROW(i + step[k].y, value), *factors = ROW(i + step[k].x, x);
    FOR_PARTS(c) sum[c] += AT(c, numbers) * AT(c, factors);
  }
  FOR_PARTS(c) product[c] = sum[c];
}
#endif

// The same for some rows from i on, as many as share a list and fit into a vector of 16; returns
// how many.
#if WIDTH == 1
#define LOAD_PRIVATE(k, from) (from)[k]
#define STORE_PRIVATE(lanes, to) (to)[0] = (lanes)
#else
#define LOAD_PRIVATE(k, from) JOIN(vload, WIDTH)(k, from)
#define STORE_PRIVATE(lanes, to) JOIN(vstore, WIDTH)(lanes, 0, to)
#endif
inline int rows_product(const int i, const int end, global const int* restrict list,
                        global const int2* restrict step, global const REAL* restrict value,
                        global const REAL* restrict x, REAL* product) {
#if BLOCKS && WIDTH == 3
  const int place = list[i], last = place + step[place].x;
  int rows = 1;
  while (rows < 16 / WIDTH && i + rows < end && list[i + rows] == place) ++rows;
  if (rows > 1) {
    global const REAL *numbers = ROW(i, value), *factors = ROW(i, x);
    part sum = (part)(0);
    for (int k = place + 1; k <= last; ++k) {
      sum += AT(0, ROW(step[k].y, numbers)) * AT(0, ROW(step[k].x, factors));
    }
    STORE_PART(sum, 0, product);
    return rows;
  }
#endif
  STORE_PRIVATE(row_product(i, list, step, value, x), product);
  return 1;
}
