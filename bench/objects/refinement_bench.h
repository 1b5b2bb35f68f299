// `kappamu bench objects --section refinement`: time against error of diffusion on cubes refined
// where the light asks for it, beside even cubes.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

void measure_refinement(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
