// Slices of a volume across its three axes, with one scale; the page's slider moves all of them.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "core/grid.h"
#include "core/image.h"
#include "report/drawing/html.h"

namespace kappamu::report {

/// Across z (x to the right, y down), x (z to the right, y down) and y (x to the right, z down); at
/// most eight each, of which the middle one shows until the slider moves. `range`: the scale's
/// ends; where not given, the 0.5 % and 99.5 % quantiles.
Html slices(const Volume<double>& volume, const std::string& symbol, const std::string& unit,
            std::optional<std::pair<double, double>> range = std::nullopt);

/// One layer of a volume [y][x] with a scale of its own, at up to 1024 pixels along an edge.
Html layer(const Image<float>& values, const std::string& symbol, const std::string& unit,
           const std::string& where);

/// The slider, once in the page.
Html slice_slider();

/// What the slider does: the page's only script, and its hash for the page's content security
/// policy.
extern const char* const slider_script;
extern const char* const slider_script_sha256;

}  // namespace kappamu::report
