// Blocks whose kind is known, and exposures with something wrong, for the limits of the inverse
// problem and its tests. Data are solved on a grid of choice, finer than the fit's.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/cases/inverse_case.h"

namespace kappamu::test_cases {

/// log κ [mm] and log μ [1/mm] of a place.
struct Material {
  double log_kappa = 0.0;
  double log_mu = 0.0;
};
/// At a place given as shares of the block's extents, the third along z.
using Figure3 = std::function<Material(double, double, double)>;

Figure3 even_block(double kappa, double mu);
/// Four layers of unequal depth across z, contrast 3 in κ and 4 in μ.
Figure3 layered_block(double kappa, double mu);
/// The same with contrasts by chance, 1.5 in the standard deviation of both.
Figure3 random_layers(double kappa, double mu, std::uint64_t seed);
/// Waves and two inclusions; `strength` 1 makes a contrast of about 4.
Figure3 structured_block(double kappa, double mu, double strength, std::uint64_t seed);
/// κ `contrast` times lower in a ball of a third of the block's width, as high in another.
Figure3 inclusions(double kappa, double mu, double contrast);

/// What is wrong with an exposure.
struct Mistake {
  double scale = 1.0;       ///< of all values: white reference or exposure time
  double stated_eta = 0.0;  ///< instead of the block's; 0 = right
  double shift = 0.0;       ///< voxels by which the images sit towards +u of the light
  double variance = 1.0;    ///< stated over true
  double outliers = 0.0;    ///< share of values that are anything up to the largest
};

/// Noise-free values under `light`, [pattern][v][u] on the lit face, solved on voxels split in
/// `factor`³.
SurfaceMeasurements expose_figure(const Block& block, const Figure3& figure,
                                  const std::vector<double>& light, int factor, double eta);
/// The same under side × side patches.
SurfaceMeasurements expose_figure(const Block& block, const Figure3& figure, int side, int factor,
                                  double eta = 1.3);

/// The same by Monte Carlo transport on the block's own voxels, with the variances of its noise. η
/// is 1.3, `anisotropy` g of the phase function. Pixels that too few photons reach to know their
/// noise are masked.
SurfaceMeasurements expose_photons(const Block& block, const Figure3& figure, int side,
                                   std::uint64_t seed, double anisotropy = 0.0);

/// The figure at the cell centres of `shape`.
inverse::CoefficientPair on_grid(const GridShape& shape, const Figure3& figure);

/// Gaussian noise of the kind of add_noise(), then the mistake.
void spoil(SurfaceMeasurements& measurements, double noise, const Mistake& mistake,
           std::uint64_t seed = 7);

}  // namespace kappamu::test_cases
