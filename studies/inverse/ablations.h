// What the fit's defaults gain under light it never saw (docs/theory.md, section 4): patterns held
// out, regularisers, losses where there are outliers. Sections of `kappamu-studies inverse`.
#pragma once

#include "studies/subject.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::studies {

/// Rows: a fit of each truth (smooth fields, the same with two boxes, two layers), noise and seed
/// by every variant, always a volume: variant, truth, noise, seed and measure_fit()'s numbers.
void measure_validation(const Request& request, Progress& progress, const Save& save);
void measure_regularisers(const Request& request, Progress& progress, const Save& save);
/// The block of population and coverage, back-lit.
test_cases::Block population_block(Size size);

/// Truths of four families (tests/cases/population.h) under bars and patches at three noises, by
/// the default options. Settings were chosen with --seed 1 and with 900 and above: report others.
void measure_population(const Request& request, Progress& progress, const Save& save);
void measure_losses(const Request& request, Progress& progress, const Save& save);

}  // namespace kappamu::studies
