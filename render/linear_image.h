// Images of light as lights and pictures use them: linear, R, G, B.
#pragma once

#include <filesystem>

#include "core/image.h"
#include "render/colour.h"

namespace kappamu::render {

/// Three channels, finite and not negative. EXR and Radiance files are linear; others hold sRGB
/// code values of 8 or 16 bits, as the file states. Grey images give three equal channels. Throws
/// InputError naming the file.
Image<float> read_linear_image(const std::filesystem::path& file);

inline Colour pixel(const Image<float>& image, int x, int y) {
  return {image(x, y, 0), image(x, y, 1), image(x, y, 2)};
}

/// IEC 61966-2-1, values in [0, 1].
double srgb_encoded(double linear);
double srgb_decoded(double encoded);

}  // namespace kappamu::render
