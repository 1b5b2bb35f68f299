// Where a map's pixels are no homogeneous medium each, because light reaches them through others.
#pragma once

#include <optional>
#include <string>

#include "pipeline/records/sfdi_maps.h"

namespace kappamu::pipeline::sfdi {

/// A sentence where coefficients change, beyond their deviations, over no more than light spreads:
/// how many pixels, and how a volume's fit goes on from the map. Nothing where few do.
std::optional<std::string> neighbours_warning(const WavelengthMap& map, double pixel_mm);

}  // namespace kappamu::pipeline::sfdi
