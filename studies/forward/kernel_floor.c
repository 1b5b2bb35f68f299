// The sweeps of the finest grid on one thread, outside OpenCL: what studies/kernel_floor.py links
// with the kernels' own text. Arguments: repetitions, nx, ny, nz, tile along x. Prints processor
// milliseconds (least of the repetitions) of each sweep over the whole grid, and the clock in GHz.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define PATTERNS 16

static long item;
size_t get_global_id(unsigned axis) {
  return axis == 1 ? (size_t)item : 0;
}
size_t _Z13get_global_idj(unsigned axis) {
  return get_global_id(axis);
}

void stream_down(int, int, int, int, int, int, int, const float*, int, int, int, int, int, int,
                 const float*, const float*, float*, int, float*);
void stream_up(int, int, int, int, int, int, int, const float*, int, int, int, int, int, int,
               const float*, const float*, const float*, float*, double*, int, float*);
void stream_step(int, int, int, int, int, int, int, int, const float*, const double*, const float*,
                 const float*, float*, float*, float*, double*, int, float*);
void reduced_residual(int, int, int, int, int, int, const float*, int, const float*, const float*,
                      float*, float*, double*, int, float*);

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double clock_ghz(void) {
  const long count = 30000000;  // a chain of multiplications of three cycles each
  unsigned long x = 3;
  const double before = seconds();
  for (long i = 0; i < count; ++i) __asm__ volatile("imul %0, %0" : "+r"(x));
  return 3e-9 * (double)count / (seconds() - before);
}

static unsigned long state = 88172645463325252UL;
static float uniform(void) {
  state ^= state << 13, state ^= state >> 7, state ^= state << 17;
  return (float)(state >> 40) / 16777216.0F;
}

static float* zeros(size_t floats) {
  void* memory = NULL;
  if (posix_memalign(&memory, 128, floats * sizeof(float)) != 0) exit(1);
  memset(memory, 0, floats * sizeof(float));
  return memory;
}
static float* numbers(size_t count) {
  float* all = zeros(count);
  for (size_t i = 0; i < count; ++i) all[i] = uniform() - 0.5F;
  return all;
}

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  const int repetitions = atoi(argv[1]), nx = atoi(argv[2]), ny = atoi(argv[3]), nz = atoi(argv[4]),
            tile = atoi(argv[5]), tiles = nx / tile;
  const size_t reds = (size_t)nx / 2 * ny * nz, cells = 2 * reds, coarse = cells / 8;
  float *stencils = zeros(cells * 8), *weights = zeros(reds * 3);
  for (size_t i = 0; i < cells; ++i) {
    float* g = stencils + 8 * i;
    float sum = g[7] = 0.01F + 0.02F * uniform();
    for (int k = 0; k < 6; ++k) sum += g[k] = 0.5F + uniform();
    g[6] = 1.0F / sum;
  }
  for (size_t i = 0; i < reds * 3; ++i) weights[i] = 0.15F + 0.2F * uniform();
  float *b = numbers(cells * PATTERNS), *x = numbers(cells * PATTERNS),
        *r = numbers(reds * PATTERNS), *z = numbers(reds * PATTERNS), *p = numbers(reds * PATTERNS),
        *next_p = zeros(reds * PATTERNS), *d = numbers(reds * PATTERNS),
        *below = numbers(coarse * PATTERNS), *to_below = zeros(coarse * PATTERNS);
  const int scratch_cells = 6 * (tile + 14) * (nz + 10) + 4 * (tile / 2 + 2) * (nz / 2 + 2);
  float* scratch = zeros((size_t)tiles * 2 * scratch_cells * PATTERNS);
  double* sums = (double*)zeros((size_t)tiles * ny * 4 * PATTERNS);
  double* scalars = (double*)zeros(6 * PATTERNS);
  for (int i = 0; i < 3 * PATTERNS; ++i) scalars[i] = 1e-3;  // d and r keep their size
  enum { down, up, step, residual, sweeps };
  double least[sweeps] = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL};
  for (int n = 0; n < repetitions; ++n) {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      const double before = seconds();
      for (item = 0; item < tiles; ++item) {
        if (sweep == down) {
          stream_down(tile / 2, ny / 2, nz / 2, 1, nx, ny, nz, stencils, nx / 2, ny / 2, nz / 2, 1,
                      1, 1, weights, r, to_below, scratch_cells, scratch);
        } else if (sweep == up) {
          stream_up(tile, ny, nz, 1, nx, ny, nz, stencils, nx / 2, ny / 2, nz / 2, 1, 1, 1, weights,
                    r, below, next_p, sums, scratch_cells, scratch);
        } else if (sweep == step) {
          stream_step(tile, ny, nz, 0, 0, nx, ny, nz, stencils, scalars, z, p, next_p, d, r, sums,
                      scratch_cells, scratch);
        } else {
          reduced_residual(tile, ny, nz, nx, ny, nz, stencils, 0, d, b, x, next_p, sums,
                           2 * scratch_cells, scratch);
        }
      }
      const double taken = seconds() - before;
      if (taken < least[sweep]) least[sweep] = taken;
    }
  }
  printf("{\"stream_down\": %.4f, \"stream_up\": %.4f, \"stream_step\": %.4f,", 1e3 * least[down],
         1e3 * least[up], 1e3 * least[step]);
  printf(" \"reduced_residual\": %.4f, \"clock_ghz\": %.4f}\n", 1e3 * least[residual], clock_ghz());
  return 0;
}
