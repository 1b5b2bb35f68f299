// What a photograph's EXIF tags hold of how it was taken.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace kappamu::io {

/// Absent where the file has no such tag.
struct PhotoSettings {
  std::optional<double> exposure_s;       ///< exposure time [s], also by ShutterSpeedValue
  std::optional<double> f_number;         ///< aperture, focal length over diameter
  std::optional<double> iso;              ///< sensitivity
  std::optional<double> focal_length_mm;  ///< [mm]
  /// By the tag, 1 to 8 (orientation.h); pictures are read as stored, without it.
  std::optional<int> orientation;
  std::string camera;  ///< model; empty if there is none
};

/// [s] of the tag ShutterSpeedValue in APEX units: 2^-apex.
std::optional<double> exposure_of_speed(double apex);

/// From JPEG, TIFF, PNG and EXR by OpenImageIO, from camera RAW files by LibRaw; nothing from files
/// without EXIF and from damaged ones. Throws InputError naming the file only if it cannot be
/// opened or claims more pixels than any photograph has (image_limits.h).
PhotoSettings read_photo_settings(const std::filesystem::path& file);

}  // namespace kappamu::io
