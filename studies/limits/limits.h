// The measured edges of the grid solver and of the fit: every table of docs/limits.md, a section
// each, in limits_*.cpp. Times belong to docs/benchmarks.md, those of objects to
// docs/objects-bench.md.
#pragma once

#include <nlohmann/json.hpp>

#include "studies/subject.h"
#include "tests/cases/limit_case.h"

namespace kappamu::studies {

// The rows of each section.
Json limit_contrast(const Request& request, Progress& progress);
Json limit_size(const Request& request, Progress& progress);
Json limit_floor(const Request& request, Progress& progress);
Json limit_absorption(const Request& request, Progress& progress);
Json limit_coarse(const Request& request, Progress& progress);
Json limit_stencil(const Request& request, Progress& progress);
Json limit_relaxation(const Request& request, Progress& progress);
Json limit_inverse(const Request& request, Progress& progress);
Json limit_consistency(const Request& request, Progress& progress);
Json limit_shared_errors(const Request& request, Progress& progress);
Json limit_objects(const Request& request, Progress& progress);

}  // namespace kappamu::studies
