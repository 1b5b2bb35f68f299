#include "render/linear_image.h"

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
  if (io::is_float_image(file)) {
    read = io::read_float_image(file, {}, io::Primaries::srgb);
  } else {
    read = io::read_relative_image(file);
    for (float& code : read.values()) code = static_cast<float>(srgb_decoded(code));
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
