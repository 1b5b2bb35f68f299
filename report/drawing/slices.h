// Slices of a volume across z, side by side with one scale.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "core/grid.h"
#include "report/drawing/html.h"

namespace kappamu::report {

/// Five depths at most, x to the right and y down. `range`: the scale's ends; where not given, the
/// 0.5 % and 99.5 % quantiles.
Html slices(const Volume<double>& volume, const std::string& symbol, const std::string& unit,
            std::optional<std::pair<double, double>> range = std::nullopt);

}  // namespace kappamu::report
