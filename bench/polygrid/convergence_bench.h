// Error against nodes processed on a polygrid, as figure 15 of [W]: its relaxations and ours.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

void measure_convergence(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
