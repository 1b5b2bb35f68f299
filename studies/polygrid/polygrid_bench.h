// Sections of `kappamu-studies polygrid` in files of their own.
#pragma once

#include "studies/subject.h"

namespace kappamu::studies {

/// Error against nodes processed on a polygrid, as figure 15 of [W]: its relaxations and ours.
void measure_convergence(const Request& request, Progress& progress, const Save& save);
/// What a live frame on a polygrid costs, beside Table III of [W].
void measure_frames(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies
