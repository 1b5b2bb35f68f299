// The table of forward/lateral: white Monte Carlo runs, and the polynomials fitted to them.
#pragma once

#include "core/progress.h"
#include "studies/record.h"
#include "studies/subject.h"

namespace kappamu::studies::sfdi {

/// White Monte Carlo, --photons for each anisotropy: the raw sums at the table's nodes.
void measure_walks(const Request& request, Progress& progress, const Save& save);

/// Fits the record of the walks and writes lateral_table.inc beside it.
void measure_table(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies::sfdi
