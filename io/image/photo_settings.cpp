#include "io/image/photo_settings.h"

#include <array>
#include <charconv>
#include <cmath>
#include <span>
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

/// The number that EXIF holds as a fraction and OpenImageIO as a float: one over a whole number
/// where it is that to the float's precision (1/30), else its shortest decimal.
std::optional<double> from_float(float value) {
  if (!positive(value)) return std::nullopt;
  const double whole = std::round(1.0 / value);
  if (whole > 1.0 && std::abs(whole * value - 1.0) < 1e-6) return 1.0 / whole;
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double decimal = 0.0;
  std::from_chars(text.data(), end, decimal);
  return positive(decimal);
}

/// APEX value.
std::optional<double> shutter_speed(const OIIO::ImageSpec& spec, std::span<const std::byte> bytes) {
  const OIIO::ParamValue* found = spec.find_attribute("Exif:ShutterSpeedValue");
  if (found != nullptr) return found->get_float();
  return tiff_number(bytes, 37377);
}

std::optional<double> number_of(const OIIO::ImageSpec& spec, const char* name) {
  const OIIO::ParamValue* found = spec.find_attribute(name);
  if (found == nullptr) return std::nullopt;
  return from_float(found->get_float());
}

}  // namespace

std::optional<double> exposure_of_speed(double apex) {
  return positive(std::exp2(-apex));
}

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
  if (!settings.exposure_s) settings.exposure_s = positive(tiff_number(bytes, 33434).value_or(0.0));
  if (const auto speed = shutter_speed(spec, bytes); speed && !settings.exposure_s) {
    settings.exposure_s = exposure_of_speed(*speed);
  }
  const int orientation = spec.get_int_attribute("Orientation", 0);
  if (orientation >= 1 && orientation <= 8) settings.orientation = orientation;
  settings.f_number = number_of(spec, "FNumber");
  if (!settings.f_number) settings.f_number = positive(tiff_number(bytes, 33437).value_or(0.0));
  settings.iso = number_of(spec, "Exif:PhotographicSensitivity");
  settings.focal_length_mm = number_of(spec, "Exif:FocalLength");
  settings.camera = spec.get_string_attribute("Model");
  return settings;
}

}  // namespace kappamu::io
