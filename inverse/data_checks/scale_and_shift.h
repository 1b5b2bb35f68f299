// What residuals of a volume never reveal: a wrong scale of all values is absorbed by κ and μ of
// voxels entirely, a shift of the images largely. A block of few layers cannot absorb either. It is
// fitted here together with the scale and the shift that suit the data best.
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
/// sandwich): light through other parts of a structured block tells another scale. Needs two
/// patterns. The objective's correction is made by `finer` at `start`, and again where that led if
/// it came near the data.
ExposureFit fit_exposure(Objective& objective, const Refinement& finer, const LayeredMedium& start,
                         const ModelError& model_error);

}  // namespace kappamu::inverse
