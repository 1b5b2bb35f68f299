// One fit of a known block, measured: what it cost and how its volume looks under light it never
// saw, along its course and at its end.
#pragma once

#include <string>
#include <vector>

#include "core/progress.h"
#include "inverse/fit/fit.h"
#include "studies/record.h"
#include "tests/cases/inverse_case.h"

namespace kappamu::studies {

/// A named set of options.
struct Variant {
  std::string name;   ///< in records: "default", "wang2008-scheme", ...
  std::string label;  ///< in legends and tables
  inverse::FitOptions options;
  /// [W]: one fixed weight. The one the default ended with is taken, which no user of [W] knows.
  bool weight_of_default = false;
};

/// The default first; then L-BFGS in other coordinates, and [W]'s optimiser along our path and
/// in the paper's own scheme (one grid, homogeneous start, fixed weight).
std::vector<Variant> inverse_variants();

/// What a fit is compared with: light it does not see, and the block's own fields.
struct Validation {
  SurfaceMeasurements patches;           ///< 8 × 8 patches
  SurfaceMeasurements single;            ///< a sample of single-voxel sources
  inverse::CoefficientPair fine_fields;  ///< on the grid of the data
};
Validation make_validation(const test_cases::Block& block, inverse::CoefficientPair fine_fields,
                           int single_sources = 64);

/// Median of |found/true − 1| over each layer, lit face first; the truth averaged over the fitted
/// voxel.
struct DepthError {
  std::vector<double> kappa;
  std::vector<double> mu;
};
DepthError depth_error(const Medium& medium, const inverse::CoefficientPair& fine_fields,
                       Face lit_face);

/// Solves, work (voxel iterations over the fitted grid's voxels), seconds, chi2, weight, status and
/// device of a fit, with kappa_error_by_depth and mu_error_by_depth.
Json score_of(const inverse::ChannelFit& fit, const SurfaceMeasurements& measurements,
              const inverse::CoefficientPair& fine_fields);

/// Patterns kept out of the fit: none, or those that `kappamu fit` keeps out unless asked otherwise
/// and takes in again (validated_fit.h), a cost that a comparison of optimisers leaves out.
enum class KeptOut { none, usual };

/// Fits channel 0; score_of() with validation_E (8 × 8 patches), single_voxel_E and, where
/// `course_points` > 0, the course: at most about so many steps, evenly over the logarithm of the
/// solves, each as solves, work, seconds since the start (scoring left out), weight, chi2, level
/// (0 = the fitted grid) and validation_E of the volume that would be exported there.
Json measure_fit(const SurfaceMeasurements& measurements, const Validation& validation,
                 const inverse::FitOptions& options, KeptOut kept_out, int course_points,
                 Progress& progress);

}  // namespace kappamu::studies
