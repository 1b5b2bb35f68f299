#include "bench/text.h"

#include <cstdarg>
#include <cstdio>

namespace kappamu::bench {

std::string text(const char* format, ...) {
  char buffer[512];
  va_list list;
  va_start(list, format);
  std::vsnprintf(buffer, sizeof buffer, format, list);
  va_end(list);
  return buffer;
}

}  // namespace kappamu::bench
