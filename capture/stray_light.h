// Light that no subject sends: room light on it, flare in the lens.
#pragma once

#include <optional>
#include <span>

namespace kappamu::capture {

/// Light that a chart's patches show beside what they reflect, as a share of white: b/a of
/// measured = a published + b over patches of known reflectance, by least squares of relative
/// residuals. Room light and flare are not told apart. Nothing for fewer than three patches or dark
/// ones.
std::optional<double> stray_light(std::span<const double> published,
                                  std::span<const double> measured);

}  // namespace kappamu::capture
