// How far the fitted volumes can be trusted: the covariance of (log κ, log μ) at the minimum of
// ½ χ² + α R, linearised there,
//     C = (JᵀWJ + α R″)⁻¹,
// the regulariser α R taken as what is known beforehand, with covariance (α R″)⁻¹. What that means,
// and what the data leave undetermined, is in docs/theory.md, section 5.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/grid.h"
#include "inverse/optimise/basis.h"
#include "inverse/problem/objective.h"
#include "inverse/regulariser/roughness.h"
#include "inverse/uncertainty/prior.h"
#include "inverse/uncertainty/shared_deviation.h"

namespace kappamu::inverse {

/// Default of `kappamu fit` and `kappamu run` for either kind below.
inline constexpr int usual_probes = 8;

struct UncertaintyOptions {
  int probes = 0;  ///< adjoint solves at the fit's end for its deviations; 0 = none
  /// Adjoint solves for where the data constrain the volume (sensitivity.h), deviations or not.
  int sensitivity_probes = 0;
};

/// One layer of voxels parallel to the seen face; medians over the layer.
struct LayerUncertainty {
  double depth_mm = 0.0;       ///< of the layer's middle below the seen face
  double log_kappa_std = 0.0;  ///< [dimensionless]
  double log_mu_std = 0.0;     ///< [dimensionless]
  /// Width of the means that the deviations refer to (point_spread.h); 0: the values themselves.
  double kappa_fwhm_mm = 0.0;
  double mu_fwhm_mm = 0.0;
  double kappa_resolution = 0.0;
  double mu_resolution = 0.0;
  double correlation = 0.0;
};

struct UncertaintyReport {
  std::vector<LayerUncertainty> layers;   ///< from the seen face down
  std::string sentence;                   ///< summary of the layers
  std::optional<SharedDeviation> shared;  ///< included (shared_deviation.h); volumes only
  int solves = 0;                         ///< batched ones that this cost
  double seconds = 0.0;
};

struct Uncertainty {
  /// Standard deviation of log κ [dimensionless], as a mean over what the fit resolves there.
  Volume<float> log_kappa_std;
  Volume<float> log_mu_std;  ///< of log μ
  /// Share of the prior's variance that the data removed, 1 − C_ii/((α R″)⁻¹)_ii: 1 = the data
  /// decide, 0 = the smoothing does.
  Volume<float> kappa_resolution;
  Volume<float> mu_resolution;
  Volume<float> correlation;  ///< of log κ and log μ of one voxel, −1 to 1
  UncertaintyReport report;
};

/// (JᵀWJ + α R″) v at the fields of the objective's last value(): one tangent and one adjoint
/// solve.
CoefficientPair hessian_product(Objective& objective, const Prior& prior, const CoefficientPair& v);

/// JᵀWJ in blocks for what follows, of `rows` by random_rows() (lateral_hessian.h).
LateralBlocks prior_blocks(std::span<const CoefficientPair> rows, const MediumSpace& space);

/// The guess of the posterior's covariance by these blocks.
Basis posterior_metric(const Prior& prior, const MediumSpace& space, const LateralBlocks& blocks);

/// The same before the data, (α R″)⁻¹.
Basis prior_metric(const Prior& prior, const MediumSpace& space);

/// C by that guess, of `blocks` by prior_blocks() at the minimum, shared out across the light by
/// the `sensitivity` there (local_information.h); beside it in both deviations what C cannot know,
/// `shared` (shared_deviation.h).
Uncertainty estimate_uncertainty(const Prior& prior, const MediumSpace& space, Face seen_face,
                                 const LateralBlocks& blocks, const CoefficientPair& sensitivity,
                                 const SharedDeviation& shared);

/// Medians of the voxels of each layer, from the seen face down.
std::vector<LayerUncertainty> layers_below(const Uncertainty& found, Face seen_face);

/// Summary of the layers: best and worst layer of each coefficient, where the data do
/// not determine it to a factor of two, where the smoothing decides, and where κ trades against μ.
std::string in_words(const std::vector<LayerUncertainty>& layers);

}  // namespace kappamu::inverse
