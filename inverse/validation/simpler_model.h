// The last word on the model: light that no model was fitted to.
#pragma once

#include "core/surface_measurements.h"
#include "inverse/fit/fit.h"

namespace kappamu::inverse {

/// Takes the simplest of fit.simpler whose χ² under `validation` exceeds the volume's by no more
/// than the sampling error of the difference: what stated variances reject because they are
/// understated or because calibration errors look like structure. `fitted` are the measurements of
/// the fit. Medium, prediction, model, status and χ² of `fit` become those of the model taken.
void prefer_simpler(ChannelFit& fit, const SurfaceMeasurements& fitted,
                    const SurfaceMeasurements& validation, int channel, const FitOptions& options);

}  // namespace kappamu::inverse
