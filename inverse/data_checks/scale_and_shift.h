// Scale of all values and shift of the images, fitted together with a block of few layers. κ and μ
// of voxels absorb a wrong scale entirely and a shift largely; few layers absorb neither.
#pragma once

#include "inverse/block_model/block_model.h"
#include "inverse/problem/objective.h"

namespace kappamu::inverse {

/// A number and its standard deviation.
struct Estimate {
  double value = 0.0;
  double error = 0.0;
};

struct ExposureFit {
  LayeredMedium medium;
  Estimate log_scale;  ///< of the data over what they should be [natural log]
  Estimate shift_u;    ///< of the images against the light, along +u of the seen face [voxels]
  Estimate shift_v;    ///< along +v
  double heterogeneity = 0.0;   ///< rms of log data that neither noise nor the fit explains
  double chi2_per_value = 0.0;  ///< with scale and shift
  double coherent = 0.0;        ///< as in model_evidence.h
  bool explains = false;        ///< the data, to their noise
  bool converged = false;
};

/// Levenberg-Marquardt on the logarithms of the data that stand above their noise, each with the
/// heterogeneity added to its spread, from `start`. Errors are those between patterns (Huber's
/// sandwich estimator), because light through other parts of a structured block gives another
/// scale. Needs two patterns. `finer` gives the correction r at `start`, and again at the end of a
/// fit that comes near the data.
ExposureFit fit_exposure(Objective& objective, const Refinement& finer, const LayeredMedium& start,
                         const ModelError& model_error);

}  // namespace kappamu::inverse
