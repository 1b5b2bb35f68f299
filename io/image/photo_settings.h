// What a photograph's EXIF tags tell of how it was taken.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace kappamu::io {

/// Absent where the file does not tell.
struct PhotoSettings {
  std::optional<double> exposure_s;       ///< exposure time [s]
  std::optional<double> f_number;         ///< aperture, focal length over diameter
  std::optional<double> iso;              ///< sensitivity
  std::optional<double> focal_length_mm;  ///< [mm]
  std::string camera;                     ///< model; empty if not told
};

/// From JPEG, TIFF, PNG, DNG, CR2 and other files that Exiv2 reads; nothing from files without
/// EXIF. Throws InputError naming the file only if it cannot be opened.
PhotoSettings read_photo_settings(const std::filesystem::path& file);

}  // namespace kappamu::io
