// The measured edges of the grid solver and of the fit: every table of docs/limits.md, a section
// each, in limits_*.cpp. Times belong to docs/benchmarks.md, those of objects to docs/embedded.md.
#pragma once

#include "bench/subject.h"

namespace kappamu::bench {

Subject limits_subject();

void limit_contrast(const Request& request, Progress& progress, const Save& save);
void limit_size(const Request& request, Progress& progress, const Save& save);
void limit_floor(const Request& request, Progress& progress, const Save& save);
void limit_absorption(const Request& request, Progress& progress, const Save& save);
void limit_mirror(const Request& request, Progress& progress, const Save& save);
void limit_shape(const Request& request, Progress& progress, const Save& save);
void limit_boundary(const Request& request, Progress& progress, const Save& save);
void limit_coarse(const Request& request, Progress& progress, const Save& save);
void limit_stencil(const Request& request, Progress& progress, const Save& save);
void limit_relaxation(const Request& request, Progress& progress, const Save& save);
void limit_inverse(const Request& request, Progress& progress, const Save& save);
void limit_consistency(const Request& request, Progress& progress, const Save& save);
void limit_objects(const Request& request, Progress& progress, const Save& save);
void limit_object_cost(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::bench
