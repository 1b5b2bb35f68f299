// Light that no subject sends: room light on it, flare in the lens.
#pragma once

#include <cstddef>
#include <optional>

#include "calib/light/radiometry.h"

namespace kappamu::calib {

/// Light that the chart's neutral patches show beside what they reflect, as a share of white: b/a
/// of measured = a published + b, by least squares of relative residuals. Room light and flare are
/// not separated. Nothing for fewer than three usable patches or dark ones.
std::optional<double> stray_light(const ChartReference& chart, std::size_t channel);

}  // namespace kappamu::calib
