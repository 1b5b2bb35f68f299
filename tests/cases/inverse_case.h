// Blocks of known κ(x), μ(x) for measurements of the inverse problem: data from a grid twice as
// fine as the fitted one, with noise, and the score of a volume under light the fit never saw. The
// fitted discretisation never makes the data it is evaluated on.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/grid.h"
#include "core/surface_measurements.h"
#include "inverse/problem/fields.h"
#include "inverse/problem/predict.h"

namespace kappamu::test_cases {

/// Normal numbers that are the same on every platform (Box-Muller over mt19937_64).
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : engine_(seed) {}
  double normal();
  double uniform();  ///< in (0, 1)

 private:
  std::mt19937_64 engine_;
};

/// A block and how it is seen; `grid` is the fitted one.
struct Block {
  GridShape grid{16, 16, 6, 0.5};
  Face lit = Face::z_minus;
  Face seen = Face::z_plus;
  Light light = Light::collimated;
  Quantity quantity = Quantity::exitance;
  double noise = 0.01;  ///< σ = noise (value + noise · the pattern's maximum)
  /// Of what makes the data and evaluates on them: single solves to 1e-6, double to 1e-9.
  forward::Precision precision = forward::Precision::double_precision;
};

/// Smooth random fields, and in them a box of low κ and a box of high μ, both `contrast` times
/// beside their surroundings, about a quarter of the block wide and anywhere in it.
struct TruthSpec {
  double kappa = 0.2;     ///< geometric mean of the smooth part [mm]
  double mu = 0.01;       ///< the same [1/mm]
  double contrast = 4.0;  ///< largest over smallest of the smooth part
  bool inclusions = true;
  /// Boxes of 3 × 3 × 1.5 mm with a millimetre of the block around them, κ a third only, and fields
  /// that vary per mm as much along the light as across it: like the block of another author that
  /// tests/inverse/fit/transport_reference_test.cpp fits.
  bool embedded = false;
  std::uint64_t seed = 1;
};
/// On the cell centres of `shape`; equal specs give the same figure on every grid.
inverse::CoefficientPair make_truth(const GridShape& shape, const TruthSpec& spec);

/// One lit voxel per pattern, `count` of them spread over the face by chance: [count][v][u].
std::vector<double> single_voxel_light(FaceShape face, int count, std::uint64_t seed);

/// Noise-free values under `irradiance` [patterns][v][u] on the block's lit face: `fine_fields` are
/// given, and solved, on block.grid.refined(2). Variances are 1.
SurfaceMeasurements expose(const Block& block, const inverse::CoefficientPair& fine_fields,
                           const std::vector<double>& irradiance);
/// The same under side × side patches.
SurfaceMeasurements expose_patches(const Block& block, const inverse::CoefficientPair& fine_fields,
                                   int side);

/// Adds Gaussian noise and states its variance; where one face is lit and seen, lit pixels are
/// masked.
void add_noise(SurfaceMeasurements& measurements, double noise, std::uint64_t seed);

/// Multiplies the values by 1 plus errors that neighbouring pixels share, drawn by the law that
/// states them (inverse/problem/smooth_error.h).
void add_smooth_error(SurfaceMeasurements& measurements, const SmoothError& error, Noise& noise);

/// expose_patches() with noise.
SurfaceMeasurements measure(const Block& block, const inverse::CoefficientPair& fine_fields,
                            int side = 4, std::uint64_t seed = 7);

/// E = Σ(L' − L)²/ΣL² ([W] 6.1) of `medium`, every voxel split in 2³ and nothing corrected but
/// diffusion itself where `how` asks for photons, against what expose() gave; where one face is lit
/// and seen, over the unlit pixels. Masked ones are left out.
double appearance_error(const Medium& medium, const SurfaceMeasurements& exposed,
                        const inverse::PredictOptions& how = {});

}  // namespace kappamu::test_cases
