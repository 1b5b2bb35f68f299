// The photographs of a folder, which shot each belongs to and how it was taken.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/session/session.h"
#include "capture/session/session_files.h"
#include "core/progress.h"
#include "io/image/photo_settings.h"

namespace kappamu::capture {

/// Where photographs are found.
struct PhotographSource {
  std::filesystem::path folder;                ///< searched with its subfolders
  std::optional<std::filesystem::path> table;  ///< CSV: file, shot and, optionally, exposure_s
  Links links = Links::within;
};

struct Photograph {
  std::filesystem::path path;
  std::string shot;  ///< "fit_00", "board", "plane_03_projected", "sample_back", "dark", ...
  io::PhotoSettings settings;
  double exposure_s = 0.0;  ///< [s], from EXIF or the table; 0: in neither
};

/// By shot, then exposure time, then name; an exposure time that neither EXIF nor the table has is
/// 0. Of a RAW and a JPEG with one name the RAW is taken. Throws as import_session().
std::vector<Photograph> find_photographs(const PhotographSource& source, Progress& progress);

/// Throws, naming the photograph, if one has no exposure time.
void require_exposure_times(const std::vector<Photograph>& photographs);

/// Size, depth and encoding as a photograph has them; what it cannot say stays as it is.
void read_camera(const std::filesystem::path& photograph, Camera& camera);

/// Throws unless all photographs have one camera, aperture, sensitivity and focal length, as far as
/// they tell.
void check_settings(const std::vector<Photograph>& photographs);

}  // namespace kappamu::capture
