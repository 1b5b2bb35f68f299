#pragma once

#include <utility>
#include <vector>

#include "core/numbers/median.h"

namespace kappamu::pipeline::sfdi {

/// upper_median(), and 0 of none.
inline double median(std::vector<double> values) {
  return values.empty() ? 0.0 : upper_median(std::move(values));
}

}  // namespace kappamu::pipeline::sfdi
