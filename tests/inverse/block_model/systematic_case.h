// What a real rig leaves in its measurements beyond noise: photographs interpolated between pixels,
// a pose and a response a little wrong.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid.h"
#include "core/surface_measurements.h"

namespace kappamu::test_cases {

/// Bars side by side along x, as wide as `count` of them fill the lit face z− of `grid`:
/// [count][v][u].
std::vector<double> bar_light(const GridShape& grid, int count);

/// Adds to the noise-free values of `measurements` an error of relative size `size` (root mean
/// square over values, of all patterns), mixed by chance of three parts that all patterns of a rig
/// have in common: linear interpolation between camera pixels of 0.7 to 1.6 voxels, a shift of the
/// images, and the values' exponent.
void add_rig_error(SurfaceMeasurements& measurements, double size, std::uint64_t seed);

/// Adds an error of relative size `size` whose correlation between pixels d apart in one pattern is
/// exp(−d²/2 length²).
void add_correlated_error(SurfaceMeasurements& measurements, double size, double length,
                          std::uint64_t seed);

}  // namespace kappamu::test_cases
