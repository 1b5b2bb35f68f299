// The photographs of a folder, which shot each belongs to and how it was taken.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/session/session.h"
#include "capture/session/session_files.h"
#include "core/names.h"
#include "core/progress.h"
#include "io/image/photo_settings.h"

namespace kappamu::capture {

/// What is done with the photographs' EXIF orientation.
enum class Orientation {
  ignore,  ///< frames are taken as stored
  apply    ///< all frames are turned by it; all must have the same
};
inline constexpr Names<Orientation, 2> orientation_names{
    {{"ignore", Orientation::ignore}, {"apply", Orientation::apply}}};

/// Where photographs are found, and how they are held.
struct PhotographSource {
  std::filesystem::path folder;                ///< searched with its subfolders
  std::optional<std::filesystem::path> table;  ///< CSV: file, shot and, optionally, exposure_s
  Links links = Links::within;
  /// Folder of the plan, if any: images of its folder `patterns` are no photographs.
  std::filesystem::path plan{};
  std::optional<Orientation> orientation{};  ///< none: ignore, with a warning where it matters
};

struct Photograph {
  std::filesystem::path path;
  std::string shot;  ///< "fit_00", "board", "plane_03_projected", "sample_back", "dark", ...
  io::PhotoSettings settings;
  double exposure_s = 0.0;  ///< [s], from EXIF or the table; 0: in neither
};

/// By shot, then exposure time, then name; the table's exposure time goes before EXIF's, one that
/// neither has is 0. Hidden files and system folders are passed over. Of a RAW and a JPEG with one
/// name the RAW is taken. Throws as import_session().
std::vector<Photograph> find_photographs(const PhotographSource& source, Progress& progress);

/// Whether `b` is a file, not a link, of the same bytes as `a`.
bool same_content(const std::filesystem::path& a, const std::filesystem::path& b);

/// Throws, naming the photograph, if one has no exposure time.
void require_exposure_times(const std::vector<Photograph>& photographs);

/// Size, depth and encoding as a photograph has them; what it cannot say stays as it is. Gives the
/// number of its channels, 1 or 3.
int read_camera(const std::filesystem::path& photograph, Camera& camera);

/// Sets camera.orientation, and width and height as the upright picture has them, of a camera that
/// read_camera() has read. Without a wish orientations are ignored with a warning where there are
/// any. Throws InputError where photographs that are to be turned have different ones.
void settle_orientation(const std::vector<Photograph>& photographs, std::optional<Orientation> wish,
                        Camera& camera, Progress& progress);

/// Throws unless all photographs have one camera, aperture, sensitivity and focal length, as far as
/// they tell.
void check_settings(const std::vector<Photograph>& photographs);

}  // namespace kappamu::capture
