// Maps of μa and σs' from the pictures of a spatial frequency domain measurement: demodulation,
// calibration by a phantom or an absolute scale, coefficients per pixel by transport, deviations.
#pragma once

#include "core/progress.h"
#include "pipeline/records/sfdi_maps.h"
#include "pipeline/sfdi/sfdi_file.h"
#include "pipeline/sfdi/sfdi_ratios.h"

namespace kappamu::pipeline::sfdi {

/// Throws InputError naming file, field and fix.
Maps measure_maps(const Description& description, Progress& progress);

/// The map of one wavelength from ratios measured elsewhere; `map` brings its wavelength or name,
/// and checks.
WavelengthMap map_of_ratios(const Description& description, WavelengthMap map, Ratios ratios);

/// Sentences about what was found in a map's pictures. Throws InputError where no pixel is valid.
void add_map_warnings(const WavelengthMap& map, double pixel_mm,
                      std::vector<std::string>& warnings);

}  // namespace kappamu::pipeline::sfdi
