#include "io/image/image_file.h"

#include <algorithm>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "io/atomic_file.h"
#include "io/image/exr.h"
#include "io/image/oiio_input.h"
#include "io/image/picture_values.h"
#include "io/image/png_writer.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

template <class Code>
OIIO::ImageSpec spec_of(const Image<Code>& image) {
  check(!image.empty() && (image.channels() == 1 || image.channels() == 3),
        "only images of one or three channels can be written");
  return {image.width(), image.height(), image.channels(), OIIO::BaseTypeFromC<Code>::value};
}

template <class Code>
PngPixels png_pixels(const Image<Code>& image) {
  const OIIO::ImageSpec spec = spec_of(image);
  return {image.values().data(), spec.width, spec.height, spec.nchannels,
          static_cast<int>(8 * sizeof(Code))};
}

/// For camera frames: noise compresses little, and looking for runs only is faster than zlib's
/// default search and gives smaller files (measured on 16-bit frames with shot noise).
template <class Code>
std::vector<unsigned char> encode_frame_png(const Image<Code>& image) {
  return write_png(png_pixels(image), PngEffort::fast);
}

template <class Code>
std::vector<unsigned char> encode_tiff(const Image<Code>& image, const std::string& what) {
  OIIO::ImageSpec spec = spec_of(image);
  spec.attribute("compression", "lzw");
  spec.attribute("DateTime", "");  // else the present time: equal frames, equal bytes
  return encode_image("tiff", spec, image.values().data(), what);
}

template <class Code>
void write_by_extension(const fs::path& file, const Image<Code>& image) {
  const std::string extension = lower_extension(file);
  if (extension != ".png" && extension != ".tif" && extension != ".tiff") {
    throw InputError("cannot write " + file.string() +
                     ": images are written as .png, .tif or .tiff, choose one of these endings");
  }
  const auto bytes =
      extension == ".png" ? encode_frame_png(image) : encode_tiff(image, file.string());
  write_bytes_atomically(file, std::as_bytes(std::span(bytes)));
}

}  // namespace

Image<std::uint16_t> read_code_image(const fs::path& file, const SizeCheck& expected,
                                     const std::optional<Region>& part) {
  return read_codes(file, expected, part).codes;
}

Image<float> read_relative_image(const fs::path& file) {
  const CodePicture picture = read_codes(file, {});
  const float white = picture.bits == 16 ? 65535.0F : 255.0F;
  const Image<std::uint16_t>& codes = picture.codes;
  Image<float> image(codes.width(), codes.height(), codes.channels());
  std::transform(codes.values().begin(), codes.values().end(), image.values().begin(),
                 [&](std::uint16_t code) { return static_cast<float>(code) / white; });
  return image;
}

void write_image(const fs::path& file, const Image<std::uint8_t>& image) {
  write_by_extension(file, image);
}
void write_image(const fs::path& file, const Image<std::uint16_t>& image) {
  write_by_extension(file, image);
}

void write_float_image(const fs::path& file, const Image<float>& image) {
  check(image.channels() == 1 || image.channels() == 3, "float images have one or three channels");
  ExrHeader header{{0, 0, image.width(), image.height()}, image.width(), image.height(), {}, {}};
  header.channels = image.channels() == 1 ? std::vector<std::string>{"Y"}
                                          : std::vector<std::string>{"R", "G", "B"};
  const std::size_t row = static_cast<std::size_t>(image.width()) * header.channels.size();
  const auto fill = [&](int first, int rows, float* values) {
    std::copy_n(&image(0, first), static_cast<std::size_t>(rows) * row, values);
  };
  write_exr_rows(file, header, fill);
}

void write_code_image(const fs::path& file, const Image<std::uint16_t>& image, int bit_depth) {
  check(bit_depth >= 8 && bit_depth <= 16, "camera codes have 8 to 16 bits");
  const auto& codes = image.values();
  check(std::all_of(codes.begin(), codes.end(), [&](int code) { return code >> bit_depth == 0; }),
        "camera code above 2^" + std::to_string(bit_depth) + " - 1 for " + file.string());
  if (bit_depth > 8) return write_image(file, image);
  Image<std::uint8_t> narrow(image.width(), image.height(), image.channels());
  std::transform(codes.begin(), codes.end(), narrow.values().begin(),
                 [](std::uint16_t code) { return static_cast<std::uint8_t>(code); });
  write_image(file, narrow);
}

std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image) {
  return write_png(png_pixels(image), PngEffort::small);
}

std::vector<std::uint8_t> encode_jpeg(const Image<std::uint8_t>& image, int quality) {
  OIIO::ImageSpec spec = spec_of(image);
  spec.attribute("Compression", "jpeg:" + std::to_string(quality));
  return encode_image("jpeg", spec, image.values().data(), "a picture");
}

}  // namespace kappamu::io
