// Preload library: the n-th call of one kind fails, as a full disk, a lost medium or a lack of
// memory would make it. After SQLite's I/O and allocation error tests (sqlite.org/testing.html).
//   KAPPAMU_FAULT=KIND:N      the N-th call (from 1) of KIND fails; KIND:N+ also every later one
//   KAPPAMU_FAULT_COUNT=FILE  at the end the number of calls of each kind is written there
// KIND: write, rename, sync, open, malloc, thread (malloc outside the main thread). Writes to
// standard output and error are let through, as is everything before main(): what loads the program
// is not the program's.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

enum Kind { WRITE, RENAME, SYNC, OPEN, MALLOC, THREAD, KINDS };
static const char* const names[KINDS] = {"write", "rename", "sync", "open", "malloc", "thread"};
static atomic_ulong counts[KINDS];
static int chosen = -1;  // kind that fails
static unsigned long nth = 0;
static int onwards = 0;
static int ready = 0;  // main() has begun

static int fails(enum Kind kind) {
  if (!ready) return 0;
  const unsigned long n = atomic_fetch_add(&counts[kind], 1) + 1;
  return (int)kind == chosen && (n == nth || (onwards && n > nth));
}

/// THREAD: allocations of threads that main() started.
static int allocation_fails(void) {
  const int here = fails(MALLOC);
  return (gettid() != getpid() && fails(THREAD)) || here;
}

static void begin(void) {
  const char* fault = getenv("KAPPAMU_FAULT");
  for (int kind = 0; fault != NULL && kind < KINDS; ++kind) {
    const size_t length = strlen(names[kind]);
    if (strncmp(fault, names[kind], length) != 0 || fault[length] != ':') continue;
    char* end = NULL;
    nth = strtoul(fault + length + 1, &end, 10);
    onwards = *end == '+';
    chosen = kind;
  }
  ready = 1;
}

static void finish(void) {
  ready = 0;
  const char* file = getenv("KAPPAMU_FAULT_COUNT");
  if (file == NULL) return;
  FILE* out = fopen(file, "w");
  if (out == NULL) return;
  for (int kind = 0; kind < KINDS; ++kind) fprintf(out, "%s %lu\n", names[kind], counts[kind]);
  fclose(out);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
#define FAIL(code, result) \
  do {                     \
    errno = code;          \
    return result;         \
  } while (0)

ssize_t write(int fd, const void* data, size_t size) {
  if (fd > 2 && fails(WRITE)) FAIL(ENOSPC, -1);
  return REAL(write)(fd, data, size);
}

ssize_t writev(int fd, const struct iovec* parts, int count) {
  if (fd > 2 && fails(WRITE)) FAIL(ENOSPC, -1);
  return REAL(writev)(fd, parts, count);
}

size_t fwrite(const void* data, size_t size, size_t count, FILE* file) {
  if (fileno(file) > 2 && fails(WRITE)) FAIL(ENOSPC, 0);
  return REAL(fwrite)(data, size, count, file);
}

int rename(const char* from, const char* to) {
  if (fails(RENAME)) FAIL(EIO, -1);
  return REAL(rename)(from, to);
}

int fsync(int fd) {
  if (fails(SYNC)) FAIL(EIO, -1);
  return REAL(fsync)(fd);
}

int fdatasync(int fd) {
  if (fails(SYNC)) FAIL(EIO, -1);
  return REAL(fdatasync)(fd);
}

static mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

#define OPENER(name)                               \
  int name(const char* path, int flags, ...) {     \
    va_list arguments;                             \
    va_start(arguments, flags);                    \
    const mode_t mode = mode_of(flags, arguments); \
    va_end(arguments);                             \
    if (fails(OPEN)) FAIL(EMFILE, -1);             \
    return REAL(name)(path, flags, mode);          \
  }
OPENER(open)
OPENER(open64)

FILE* fopen(const char* path, const char* mode) {
  if (fails(OPEN)) FAIL(EMFILE, NULL);
  return REAL(fopen)(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  if (fails(OPEN)) FAIL(EMFILE, NULL);
  return REAL(fopen64)(path, mode);
}

// The C library's own names: dlsym() itself may allocate.
extern void* __libc_malloc(size_t size);
extern void* __libc_calloc(size_t count, size_t size);
extern void* __libc_realloc(void* old, size_t size);
extern void* __libc_memalign(size_t alignment, size_t size);

void* malloc(size_t size) {
  if (allocation_fails()) FAIL(ENOMEM, NULL);
  return __libc_malloc(size);
}

void* calloc(size_t count, size_t size) {
  if (allocation_fails()) FAIL(ENOMEM, NULL);
  return __libc_calloc(count, size);
}

void* realloc(void* old, size_t size) {
  if (allocation_fails()) FAIL(ENOMEM, NULL);
  return __libc_realloc(old, size);
}

void* aligned_alloc(size_t alignment, size_t size) {
  if (allocation_fails()) FAIL(ENOMEM, NULL);
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** result, size_t alignment, size_t size) {
  if (allocation_fails()) return ENOMEM;
  *result = __libc_memalign(alignment, size);
  return *result == NULL ? ENOMEM : 0;
}

typedef int (*Main)(int, char**, char**);
static Main program;

static int counted_main(int argc, char** argv, char** environment) {
  begin();
  const int result = program(argc, argv, environment);
  finish();
  return result;
}

int __libc_start_main(Main main, int argc, char** argv, void (*start)(void), void (*end)(void),
                      void (*loader)(void), void* stack) {
  typedef int (*Start)(Main, int, char**, void (*)(void), void (*)(void), void (*)(void), void*);
  program = main;
  return ((Start)dlsym(RTLD_NEXT, "__libc_start_main"))(counted_main, argc, argv, start, end,
                                                        loader, stack);
}
