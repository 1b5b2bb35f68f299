#include "core/process_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <limits>
#include <string>

#include "core/shown_text.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace kappamu {

double main_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double available_memory() {
  std::ifstream info("/proc/meminfo");
  for (std::string word; info >> word;) {
    double kilobytes = 0.0;
    if (word == "MemAvailable:" && info >> kilobytes) return 1024.0 * kilobytes;
  }
  return static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) *
         static_cast<double>(sysconf(_SC_PAGESIZE));
}

double usable_memory() {
  return 0.7 * main_memory();
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

#ifdef __GLIBC__
void keep_freed_memory() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

void return_freed_memory() {
  constexpr int usual_mappings = 65536, usual_threshold = 128 * 1024;  // mallopt(3)
  mallopt(M_MMAP_MAX, usual_mappings);
  mallopt(M_TRIM_THRESHOLD, usual_threshold);
  malloc_trim(0);
}
#else
void keep_freed_memory() {}
void return_freed_memory() {}
#endif

std::string gigabytes(double bytes) {
  return shown_number(bytes / 1e9, "%.1f GB");
}

}  // namespace kappamu
