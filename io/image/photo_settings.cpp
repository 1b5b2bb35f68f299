#include "io/image/photo_settings.h"

#include <cmath>
#include <exiv2/exiv2.hpp>
#include <initializer_list>
#include <vector>

#include "io/read_file.h"

namespace kappamu::io {

namespace {

/// The first of the tags that holds a positive number.
std::optional<double> number_of(const Exiv2::ExifData& exif,
                                std::initializer_list<const char*> tags) {
  for (const char* tag : tags) {
    const auto found = exif.findKey(Exiv2::ExifKey(tag));
    if (found == exif.end() || found->count() < 1) continue;
    const Exiv2::Rational value = found->toRational(0);
    if (value.second == 0) continue;
    const double number = static_cast<double>(value.first) / value.second;
    if (std::isfinite(number) && number > 0.0) return number;
  }
  return std::nullopt;
}

}  // namespace

PhotoSettings read_photo_settings(const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = read_bytes(file);
  static const bool quiet = [] {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
    return true;
  }();
  static_cast<void>(quiet);
  PhotoSettings settings;
  try {
    const auto image = Exiv2::ImageFactory::open(reinterpret_cast<const Exiv2::byte*>(bytes.data()),
                                                 static_cast<long>(bytes.size()));
    image->readMetadata();
    const Exiv2::ExifData& exif = image->exifData();
    settings.exposure_s = number_of(exif, {"Exif.Photo.ExposureTime", "Exif.Image.ExposureTime"});
    settings.f_number = number_of(exif, {"Exif.Photo.FNumber", "Exif.Image.FNumber"});
    settings.iso = number_of(exif, {"Exif.Photo.ISOSpeedRatings", "Exif.Image.ISOSpeedRatings"});
    settings.focal_length_mm =
        number_of(exif, {"Exif.Photo.FocalLength", "Exif.Image.FocalLength"});
    const auto model = exif.findKey(Exiv2::ExifKey("Exif.Image.Model"));
    if (model != exif.end()) settings.camera = model->toString();
  } catch (const Exiv2::AnyError&) {
    // A format without EXIF, or damaged tags: nothing is told. Damaged pictures are found when
    // read.
  }
  return settings;
}

}  // namespace kappamu::io
