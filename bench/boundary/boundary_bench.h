// Integral equations on surfaces, with the exact solution u = e^(λ d·x) prescribed: its q at the
// panels is the light, so that any mesh has a known answer and no facets' error.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

Subject boundary_subject();

}  // namespace kappamu::bench
