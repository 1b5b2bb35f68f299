// Borders that software filled in: registered or scanned brackets carry a band of one pure colour
// where a picture had nothing to show. It is no light, and no black either.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/image.h"

namespace kappamu::capture {

/// Sets the pixels of a filled border to `top` in every channel, as saturated, so that nothing
/// learns from them, and returns how many there are. A filled pixel is full in one channel and
/// empty in another (codes within 1 % of `top` and of 0) and hangs together with the picture's edge
/// by such pixels, half as many at least as the shorter side has. Pictures of one channel have
/// none.
std::size_t saturate_filled_border(Image<std::uint16_t>& codes, int top);

/// Whether a pixel looks like that: a filled region begins at the picture's edge with such ones.
bool is_filled(const std::uint16_t* pixel, std::size_t channels, int top);

}  // namespace kappamu::capture
