#include "io/image/photo_settings.h"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "io/image/image_integrity.h"
#include "io/image/oiio_input.h"
#include "io/image/raw_file.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace {

std::optional<double> positive(double value) {
  return std::isfinite(value) && value > 0.0 ? std::optional(value) : std::nullopt;
}

/// The number that EXIF holds as a fraction and OpenImageIO as a float: its shortest decimal, or
/// one over that of its inverse where this is shorter (1/30).
std::optional<double> from_float(float value) {
  const auto shortest = [](float number) {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
    double decimal = 0.0;
    std::from_chars(text.data(), end, decimal);
    return std::pair(end - text.data(), decimal);
  };
  if (!positive(value)) return std::nullopt;
  const auto [length, decimal] = shortest(value);
  const auto [length_of_inverse, inverse] = shortest(1.0F / value);
  return positive(length_of_inverse < length ? 1.0 / inverse : decimal);
}

std::optional<double> number_of(const OIIO::ImageSpec& spec, const char* name) {
  const OIIO::ParamValue* found = spec.find_attribute(name);
  if (found == nullptr) return std::nullopt;
  return from_float(found->get_float());
}

}  // namespace

PhotoSettings read_photo_settings(const std::filesystem::path& file) {
  if (is_raw_file(file)) return read_raw_settings(file);
  std::vector<std::byte> bytes = read_bytes(file, largest_image_file);
  PhotoSettings settings;
  // A format without EXIF, or damaged: nothing is known. Damaged pictures are found when read.
  const ImageKind kind = image_kind(bytes);
  if (kind == ImageKind::unknown || check_integrity(bytes) != Integrity::complete) return settings;
  if (const auto size = jpeg_size(bytes)) check_size(file, *size, bytes.size(), {});
  const OiioInput input(file, bytes);
  if (!input.opened()) return settings;
  const OIIO::ImageSpec& spec = input.spec();
  settings.exposure_s = number_of(spec, "ExposureTime");
  settings.f_number = number_of(spec, "FNumber");
  settings.iso = number_of(spec, "Exif:ISOSpeedRatings");
  settings.focal_length_mm = number_of(spec, "Exif:FocalLength");
  settings.camera = spec.get_string_attribute("Model");
  return settings;
}

}  // namespace kappamu::io
