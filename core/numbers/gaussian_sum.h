// Gaussian means over a face.
#pragma once

#include <vector>

#include "core/grid.h"

namespace kappamu {

/// Σ over pixels of a Gaussian of `width` pixels to `power` (its middle 1) times `map` [v][u]. A
/// mean is this over that of ones, or over any other map's.
std::vector<double> gaussian_sum(const std::vector<double>& map, FaceShape face, double width,
                                 int power);

}  // namespace kappamu
