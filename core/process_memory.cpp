#include "core/process_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include "core/shown_text.h"

namespace kappamu {

double main_memory() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

std::string gigabytes(double bytes) {
  return shown_number(bytes / 1e9, "%.1f GB");
}

}  // namespace kappamu
