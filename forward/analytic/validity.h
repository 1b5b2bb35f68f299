// How far diffusion is to be trusted in a slab, read from a measured table: its error against Monte
// Carlo transport over albedo and thickness (docs/validity.md; `kappamu-studies validity` remakes
// the table). First-collision source, relative index 1.3, laterally even.
#pragma once

#include <optional>
#include <string>

#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

/// Relative errors of diffusion, dimensionless; unset where transport itself was not resolved
/// (almost nothing is transmitted).
struct ValidityEstimate {
  std::optional<double> reflected;    ///< total, diffusion / transport − 1
  std::optional<double> transmitted;  ///< total, diffusion / transport − 1
  std::optional<double> far_map;      ///< relative L2 on the far face under a patch, >= 0
};

/// `albedo` σs'/(σs' + μ), `mean_free_paths` thickness × (σs' + μ), > 0. Interpolates linearly in
/// the logarithms of 1 − albedo and thickness; outside the table its edge answers.
ValidityEstimate diffusion_validity(double albedo, double mean_free_paths);

/// Whether the table goes down to this albedo and thickness: diffusion errs the more below.
bool in_validity_table(double albedo, double mean_free_paths);

/// One sentence with the figures where any of them exceeds `tolerable`, taken at the block's mean
/// coefficients (κ harmonic: the mean of 1/(3κ)); nothing where diffusion holds that well.
std::optional<std::string> validity_warning(const GridSetup& setup, const Medium& medium,
                                            double tolerable = 0.03);

}  // namespace kappamu::forward
