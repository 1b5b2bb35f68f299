// Time against true error of every method that solves the diffusion equation on a grid, its growth
// with the grid, other people's solvers, and iterations against contrast.
#pragma once

#include "studies/subject.h"

namespace kappamu::studies {

/// What --json prints, from the folder's record of section peers where there is one, else of
/// headline: its comparison (comparison.h) with the relaxation of headline and kernels of that
/// section; without either these two and the names of the sections there are. Throws InputError
/// where there is none.
Json forward_summary(const std::filesystem::path& folder);

}  // namespace kappamu::studies
