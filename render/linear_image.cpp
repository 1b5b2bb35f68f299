#include "render/linear_image.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/image/image_file.h"

namespace kappamu::render {

double srgb_encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

double srgb_decoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Image<float> read_linear_image(const std::filesystem::path& file) {
  Image<float> read;
  if (file.extension() == ".exr") {
    read = io::read_float_image(file);
  } else {
    const Image<std::uint16_t> codes = io::read_code_image(file);
    read = Image<float>(codes.width(), codes.height(), codes.channels());
    const auto largest = *std::max_element(codes.values().begin(), codes.values().end());
    const double white = largest > 255 ? 65535.0 : 255.0;
    std::transform(codes.values().begin(), codes.values().end(), read.values().begin(),
                   [&](std::uint16_t code) { return srgb_decoded(code / white); });
  }
  Image<float> image(read.width(), read.height(), 3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = read(x, y, read.channels() == 1 ? 0 : c);
        if (!(value >= 0.0F && std::isfinite(value))) {
          throw InputError(file.string() + ": pixel (" + std::to_string(x) + ", " +
                           std::to_string(y) + ") is negative or not finite; correct the image");
        }
        image(x, y, c) = value;
      }
    }
  }
  return image;
}

}  // namespace kappamu::render
