// printf into a string, for tables.
#pragma once

#include <string>

namespace kappamu::bench {

/// At most 511 bytes.
__attribute__((format(printf, 1, 2))) std::string text(const char* format, ...);

}  // namespace kappamu::bench
