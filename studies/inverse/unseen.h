// The fit as it stands on blocks that no choice has seen, beside the same fits of another build. A
// section of `kappamu-studies inverse`.
#pragma once

#include "studies/subject.h"

namespace kappamu::studies {

/// Truths of four families (tests/cases/population.h), fitted as `kappamu fit` does: data with
/// noise of three sizes, with errors that pixels share, 1.5 times too bright, and with images one
/// voxel off. `rows`: of every kind of data and of all right ones together, the mean of every
/// figure (geometric of E, errors and work) and its standard error over the truths; with the
/// setting `against`, a record of another build, also the mean of the paired differences (of
/// logarithms where the mean is geometric) and their standard error. `fits`: every fit.
void measure_unseen(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies
