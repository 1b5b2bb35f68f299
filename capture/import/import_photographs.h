// The photographs of a folder, which shot each belongs to and how it was taken.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/import/import.h"
#include "core/progress.h"
#include "io/image/photo_settings.h"

namespace kappamu::capture {

struct Photograph {
  std::filesystem::path path;
  std::string shot;  ///< "fit_00", "board", "plane_03_projected", "sample_back", "dark", ...
  io::PhotoSettings settings;
  double exposure_s = 0.0;  ///< [s], from EXIF or the table
};

/// By shot, then exposure time, then name. Of a RAW and a JPEG with one name the RAW is taken.
/// Throws as import_session().
std::vector<Photograph> find_photographs(const ImportOptions& options, Progress& progress);

/// Throws unless all photographs have one camera, aperture, sensitivity and focal length, as far as
/// they tell.
void check_settings(const std::vector<Photograph>& photographs);

}  // namespace kappamu::capture
