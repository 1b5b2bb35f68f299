// Maps of μa and σs' from the pictures of a spatial frequency domain measurement: demodulation,
// calibration by a phantom or an absolute scale, coefficients per pixel by transport, deviations.
#pragma once

#include "core/progress.h"
#include "pipeline/records/sfdi_maps.h"
#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

/// Throws InputError naming file, field and fix.
Maps measure_maps(const Description& description, Progress& progress);

}  // namespace kappamu::pipeline::sfdi
