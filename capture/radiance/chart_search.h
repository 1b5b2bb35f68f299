// Where a ColorChecker Classic lies in a photograph: OpenCV's mcc detector, whose box is good to a
// quarter of a patch, and then the patches' own outlines.
#pragma once

#include <array>
#include <optional>

#include "capture/session/session.h"
#include "core/image.h"

namespace kappamu::capture {

struct ChartPlace {
  /// Centres [px] of the dark skin, bluish green, black and white patches, as in
  /// ColourChart::corners_px.
  std::array<std::array<double, 2>, 4> corners_px{};
  int patches = 0;  ///< of 24 whose own outline was seen; the others follow from the lattice
};

/// In one photograph of three channels, at any brightness and in any turn. Nothing if no chart is
/// found, fewer than half of its patches show an outline, or its neutrals do not fall from white to
/// black.
std::optional<ChartPlace> find_chart_place(const Image<std::uint16_t>& codes, Encoding encoding);

/// In that frame of the stack which shows most patches.
std::optional<ChartPlace> find_chart_place(const Session& session, const Stack& stack);

}  // namespace kappamu::capture
