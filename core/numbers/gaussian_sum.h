// Gaussian means over a face and over a block.
#pragma once

#include <vector>

#include "core/grid.h"

namespace kappamu {

/// Σ over pixels of a Gaussian of `width` pixels to `power` (its middle 1) times `map` [v][u]. A
/// mean is this over that of ones, or over any other map's.
std::vector<double> gaussian_sum(const std::vector<double>& map, FaceShape face, double width,
                                 int power);

/// Means of `field` over Gaussians of what lies in the block; `fwhm_mm` is their full width at half
/// maximum in each layer from the face `from` on, 0 = the voxel alone.
Volume<double> gaussian_means(const Volume<double>& field, Face from,
                              const std::vector<double>& fwhm_mm);

}  // namespace kappamu
