// `kappamu bench objects --section auto`: model `auto` on scenes that its table was not made from.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

void measure_auto(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
