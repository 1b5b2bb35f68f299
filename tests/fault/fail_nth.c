// Preload library: the n-th call of one kind fails, as a full disk, a lost medium or a lack of
// memory would make it. After SQLite's I/O and allocation error tests (sqlite.org/testing.html).
//   KAPPAMU_FAULT=KIND:N      the N-th call (from 1) of KIND fails; KIND:N+ also every later one
//   KAPPAMU_FAULT_COUNT=FILE  at the end the number of calls of each kind is written there
//   KAPPAMU_FAULT_SERVER=R:W  instead of one run, one for each line KIND:N that is read from file
//                             descriptor R: a fork runs main() and its exit code is written to W, so
//                             that loading, longer than many runs, is done once
// KIND: write, rename, sync, open, malloc, thread (malloc outside the main thread), place (the main
// thread's first malloc by each chain of callers). Writes to standard output and error are let through, as is everything before main(): what loads the program
// is not the program's.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

enum Kind { WRITE, RENAME, SYNC, OPEN, MALLOC, THREAD, PLACE, KINDS };
static const char* const names[KINDS] = {"write", "rename", "sync", "open",
                                          "malloc", "thread", "place"};
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

/// Whether nobody has allocated for the same chain of callers before.
__attribute__((noinline)) static int new_place(void) {
  // ABOVE: this, allocation_fails(), malloc() and its caller, mostly operator new.
  enum { ABOVE = 4, CALLERS = 4, PLACES = 1 << 16 };
  static uint64_t seen[PLACES];
  static int inside = 0;  // the first backtrace() allocates
  if (!ready || inside) return 0;
  inside = 1;
  void* frames[ABOVE + CALLERS];
  const int depth = backtrace(frames, ABOVE + CALLERS);
  inside = 0;
  uint64_t hash = 0;
  for (int i = ABOVE; i < depth; ++i) {
    hash = (hash ^ (uintptr_t)frames[i]) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  for (uint64_t i = 0; i < PLACES; ++i) {
    uint64_t* const slot = &seen[(hash + i) % PLACES];
    if (*slot == hash) return 0;
    if (*slot == 0) {
      *slot = hash;
      return 1;
    }
  }
  return 0;
}

__attribute__((noinline)) static int allocation_fails(void) {
  const int here = fails(MALLOC);
  if (gettid() != getpid()) return fails(THREAD) || here;
  return (new_place() && fails(PLACE)) || here;
}

static void choose(const char* fault) {
  for (int kind = 0; fault != NULL && kind < KINDS; ++kind) {
    const size_t length = strlen(names[kind]);
    if (strncmp(fault, names[kind], length) != 0 || fault[length] != ':') continue;
    char* end = NULL;
    nth = strtoul(fault + length + 1, &end, 10);
    onwards = *end == '+';
    chosen = kind;
  }
}

/// Returns in the forks alone.
static void serve(int orders, int results) {
  char line[64];
  for (size_t length = 0; read(orders, line + length, 1) == 1;) {
    if (line[length] != '\n') {
      if (length + 1 < sizeof line) ++length;
      continue;
    }
    line[length] = '\0';
    length = 0;
    const pid_t child = fork();
    if (child == 0) {
      close(orders);
      close(results);
      choose(line);
      return;
    }
    int status = 0;
    waitpid(child, &status, 0);
    dprintf(results, "%d\n", WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status));
  }
  _exit(0);
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

// The loader's threads are not in a fork, whose end must not wait for them.
static int forked = 0;

void exit(int code) {
  if (!forked) REAL(exit)(code);
  fflush(NULL);
  _exit(code);
}

typedef int (*Main)(int, char**, char**);
static Main program;

static int counted_main(int argc, char** argv, char** environment) {
  int orders = 0, results = 0;
  const char* server = getenv("KAPPAMU_FAULT_SERVER");
  forked = server != NULL && sscanf(server, "%d:%d", &orders, &results) == 2;
  if (forked)
    serve(orders, results);
  else
    choose(getenv("KAPPAMU_FAULT"));
  ready = 1;
  const int result = program(argc, argv, environment);
  finish();
  if (forked) exit(result);
  return result;
}

int __libc_start_main(Main main, int argc, char** argv, void (*start)(void), void (*end)(void),
                      void (*loader)(void), void* stack) {
  typedef int (*Start)(Main, int, char**, void (*)(void), void (*)(void), void (*)(void), void*);
  program = main;
  return ((Start)dlsym(RTLD_NEXT, "__libc_start_main"))(counted_main, argc, argv, start, end,
                                                        loader, stack);
}
