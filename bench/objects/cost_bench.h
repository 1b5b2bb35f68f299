// Section `cost`: seconds of every model against triangles and elements.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

void measure_costs(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
