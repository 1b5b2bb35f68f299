// What a live frame on a polygrid costs, beside Table III of [W].
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

void measure_frames(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
