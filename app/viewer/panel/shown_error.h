// A relative error as the window writes it.
#pragma once

#include <string>

#include "core/shown_text.h"

namespace kappamu::app {

inline std::string shown_error(double error) {
  constexpr double all = 0.995;  // beyond, two digits would be 1e+02
  return error < all ? shown_number(100.0 * error, "%.2g") + " %" : "100 % or more";
}

}  // namespace kappamu::app
