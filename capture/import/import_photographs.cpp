#include "capture/import/import_photographs.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <utility>

#include "capture/session/frames.h"
#include "capture/session/session_files.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/csv_table.h"
#include "io/image/image_file.h"
#include "io/image/orientation.h"
#include "io/image/raw_file.h"
#include "io/read_file.h"

namespace kappamu::capture {
namespace {

namespace fs = std::filesystem;

// Cameras round the numbers they write.
constexpr double equal_settings = 0.02;

bool is_photograph(const fs::path& file) {
  static const std::set<std::string> endings{".png",  ".tif", ".tiff", ".jpg",
                                             ".jpeg", ".bmp", ".exr"};
  return endings.count(lower_extension(file)) > 0 || io::is_raw_file(file);
}

// The shot that a file name tells: fit_00_3.png is of fit_00, plane_02_board.jpg of plane_02_board.
std::string shot_of(const fs::path& file) {
  const std::string stem = file.stem().string();
  static const std::regex whole("plane_[0-9]+_(board|projected|(gray|phase)_[0-9]+)|sample_.+");
  if (std::regex_match(stem, whole)) return stem;
  static const std::regex numbered("(.+)_[0-9]+");
  std::smatch match;
  return std::regex_match(stem, match, numbered) ? match[1].str() : stem;
}

/// What systems and programs put beside photographs and do not show: hidden files, previews,
/// archives' second halves, bins.
bool is_hidden(const fs::path& file) {
  static const std::set<std::string> names{"__macosx",  "@eadir",       "@recycle",
                                           "#recycle",  "$recycle.bin", "system volume information",
                                           "thumbs.db", "desktop.ini",  "lost+found"};
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.starts_with('.') || name.starts_with("@__") || names.count(name) > 0;
}

/// An image that the projector showed, which lies there as in the plan's folder `patterns`.
bool is_projected(const fs::path& file, const fs::path& plan) {
  const fs::path shown = plan / "patterns" / file.filename();
  return !plan.empty() && file.parent_path().filename() == "patterns" && same_content(file, shown);
}

/// Throws where one photograph, or all of a folder, would be read twice by way of a link.
class ReadOnce {
 public:
  void add(const fs::path& path) {
    const auto [other, added] = read_.emplace(fs::canonical(path), path);
    if (added) return;
    throw InputError(path.string() + ": is read already as " + other->second.string() +
                     ", one of the two by a symbolic link; take the link out");
  }

 private:
  std::map<fs::path, fs::path> read_;
};

/// The folder's files, those of folders that are links too.
std::vector<fs::path> photographs_below(const PhotographSource& source, Progress& progress) {
  const fs::path& folder = source.folder;
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(folder.string() + ": no such folder; give the folder of the photographs.");
  }
  std::vector<fs::path> files;
  int hidden = 0;
  ReadOnce folders, once;
  folders.add(folder);
  const auto links = fs::directory_options::follow_directory_symlink;
  for (fs::recursive_directory_iterator entry(folder, links), end; entry != end; ++entry) {
    const fs::path& path = entry->path();
    if (is_hidden(path)) {
      entry.disable_recursion_pending();
      ++hidden;
    } else if (!fs::exists(path, error)) {
      throw InputError(path.string() +
                       ": is a symbolic link that leads nowhere; put back what it leads to or take "
                       "the link out");
    } else if (fs::is_directory(path, error)) {
      folders.add(path);
      if (entry->is_symlink() && source.links == Links::within) {
        require_inside(folder, path.lexically_relative(folder));  // before all that lies there
      }
    } else if (fs::is_regular_file(path, error) && is_photograph(path) &&
               !is_projected(path, source.plan)) {
      files.push_back(path);
    }
  }
  if (hidden > 0) {
    progress.warn(folder.string() + ": " + std::to_string(hidden) +
                  " hidden files and folders are ignored.");
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) once.add(file);
  // A camera set to RAW + JPEG writes both under one name.
  std::set<fs::path> raw_stems;
  for (const fs::path& file : files) {
    if (io::is_raw_file(file)) raw_stems.insert(file.parent_path() / file.stem());
  }
  const auto beside_raw = [&](const fs::path& file) {
    return !io::is_raw_file(file) && raw_stems.count(file.parent_path() / file.stem()) > 0;
  };
  const auto twins = std::count_if(files.begin(), files.end(), beside_raw);
  if (twins > 0) {
    progress.warn(std::to_string(twins) +
                  " photographs are there as RAW and in another format; the RAW files are taken.");
    files.erase(std::remove_if(files.begin(), files.end(), beside_raw), files.end());
  }
  if (files.empty()) {
    throw InputError(folder.string() + ": holds no photographs (PNG, TIFF, JPEG, EXR or RAW).");
  }
  return files;
}

double seconds_in(const std::string& text, const std::string& where) {
  // 1/30 is how cameras and people write it.
  const std::size_t slash = text.find('/');
  const std::optional<double> value = io::csv_number(text.substr(0, slash));
  const std::optional<double> divisor =
      slash == std::string::npos ? 1.0 : io::csv_number(text.substr(slash + 1));
  if (!value || !divisor || !(*value / *divisor > 0.0)) {
    throw InputError(where + ": '" + shown_name(text) +
                     "' is no exposure time; write seconds, such as 0.5 or 1/30.");
  }
  return *value / *divisor;
}

std::vector<Photograph> from_table(const PhotographSource& source) {
  std::vector<Photograph> photographs;
  std::set<std::pair<std::string, std::string>> listed;  // file and shot
  const auto take = [&](const std::vector<std::string>& cells, const std::string& where) {
    const std::string &file = cells[0], &shot = cells[1], &exposure = cells[2];
    if (!stays_inside(file)) {
      throw InputError(where + ": '" + shown_name(file) +
                       "' leaves the photographs' folder; write file names relative to it.");
    }
    require_plain_name(shot, where + ": the shot");
    if (!listed.emplace(fs::path(file).lexically_normal().string(), shot).second) {
      throw InputError(where + ": lists '" + shown_name(file) + "' for '" + shot +
                       "' once more; each exposure has its own file, take one line out.");
    }
    Photograph photograph;
    photograph.path = source.folder / file;
    photograph.shot = shot;
    std::error_code ignored;
    if (!fs::is_regular_file(photograph.path, ignored)) {
      throw InputError(where + ": " + photograph.path.string() + ": no such photograph.");
    }
    if (!exposure.empty()) photograph.exposure_s = seconds_in(exposure, where);
    photographs.push_back(std::move(photograph));
  };
  io::read_csv(*source.table, {{"file"}, {"shot"}, {"exposure_s", false}}, take);
  if (photographs.empty()) throw InputError(source.table->string() + ": lists no photographs.");
  return photographs;
}

std::string shown(double value) {
  return shown_number(value, "%.4g");
}

bool differ(double a, double b) {
  return std::abs(a - b) > equal_settings * std::max(a, b);
}

}  // namespace

bool same_content(const fs::path& a, const fs::path& b) {
  std::error_code error;
  const bool files = fs::symlink_status(b, error).type() == fs::file_type::regular;
  return files && fs::file_size(a) == fs::file_size(b) && io::read_bytes(a) == io::read_bytes(b);
}

std::vector<Photograph> find_photographs(const PhotographSource& source, Progress& progress) {
  std::vector<Photograph> photographs;
  if (source.table) {
    photographs = from_table(source);
  } else {
    for (const fs::path& file : photographs_below(source, progress)) {
      photographs.push_back({file, shot_of(file), {}, 0.0});
    }
  }
  int overruled = 0;
  std::string first_overruled;
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    Photograph& photograph = photographs[i];
    if (source.links == Links::within) {
      require_inside(source.folder, photograph.path.lexically_relative(source.folder));
    }
    progress.update("import", 0.3 * static_cast<double>(i) / photographs.size(),
                    photograph.path.filename().string());
    photograph.settings = io::read_photo_settings(photograph.path);
    const std::optional<double>& exif_s = photograph.settings.exposure_s;
    if (photograph.exposure_s == 0.0) {
      photograph.exposure_s = exif_s.value_or(0.0);
    } else if (exif_s && differ(photograph.exposure_s, *exif_s) && overruled++ == 0) {
      first_overruled = photograph.path.string() + ": the table says " +
                        shown(photograph.exposure_s) + " s, EXIF says " + shown(*exif_s) + " s";
    }
  }
  if (overruled > 0) {
    progress.warn(first_overruled + "; the table is taken" +
                  (overruled == 1 ? "."
                                  : ", as for " + std::to_string(overruled - 1) +
                                        " other photographs where the two differ."));
  }
  std::sort(photographs.begin(), photographs.end(), [](const Photograph& a, const Photograph& b) {
    return std::tie(a.shot, a.exposure_s, a.path) < std::tie(b.shot, b.exposure_s, b.path);
  });
  return photographs;
}

void require_exposure_times(const std::vector<Photograph>& photographs) {
  for (const Photograph& photograph : photographs) {
    if (photograph.exposure_s == 0.0) {
      throw InputError(
          photograph.path.string() +
              ": neither EXIF nor a table states its exposure time; give a CSV with the "
              "columns file, shot, exposure_s",
          {{"table"}});
    }
  }
}

int read_camera(const fs::path& photograph, Camera& camera) {
  if (is_headerless(camera, photograph)) return camera.raw_layout->mosaic ? 3 : 1;
  const auto take_size = [&](const auto& image) {
    camera.width = image.width();
    camera.height = image.height();
    return image.channels();
  };
  if (io::is_raw_file(photograph)) {
    const io::RawImage raw = io::read_raw(photograph);
    take_size(raw.codes);
    camera.encoding = Encoding::linear;
    camera.white_level = raw.white;
    camera.bit_depth = 8;
    while (raw.white >> camera.bit_depth != 0) ++camera.bit_depth;
    return raw.channels();
  }
  camera.white_level.reset();
  if (io::is_float_image(photograph)) {
    camera.encoding = Encoding::linear;
    return take_size(io::read_float_image(photograph));
  }
  if (lower_extension(photograph).starts_with(".j")) {
    camera.bit_depth = 8;  // JPEG: eight bits behind a tone curve
    camera.encoding = Encoding::response;
  }
  return take_size(io::read_code_image(photograph));
}

void settle_orientation(const std::vector<Photograph>& photographs, std::optional<Orientation> wish,
                        Camera& camera, Progress& progress) {
  static constexpr std::array<const char*, 9> names{"",
                                                    "",
                                                    "mirrored",
                                                    "upside down",
                                                    "upside down and mirrored",
                                                    "a quarter turn and mirrored",
                                                    "a quarter turn",
                                                    "a quarter turn and mirrored",
                                                    "a quarter turn"};
  camera.orientation.reset();
  const auto tag_of = [](const Photograph& one) { return one.settings.orientation.value_or(1); };
  const Photograph& first = photographs.front();
  const auto odd = std::find_if(
      photographs.begin(), photographs.end(),
      [&](const Photograph& photograph) { return tag_of(photograph) != tag_of(first); });
  const int tag = tag_of(first);
  if (odd != photographs.end()) {
    const std::string differing =
        first.path.string() + ": its EXIF orientation is " + std::to_string(tag) + ", that of " +
        odd->path.filename().string() + " is " + std::to_string(tag_of(*odd));
    if (wish == Orientation::apply) {
      throw InputError(differing +
                           "; an orientation is applied only where all photographs have "
                           "the same: ignore it",
                       {{"orientation", "ignore"}});
    }
    if (!wish) progress.warn(differing + "; orientations are ignored.");
    return;
  }
  if (tag == 1) return;
  if (wish == Orientation::apply) {
    camera.orientation = tag;
    if (io::swaps_sides(tag)) std::swap(camera.width, camera.height);
  } else if (!wish) {
    progress.warn("all " + std::to_string(photographs.size()) + " photographs have the EXIF " +
                  "orientation " + std::to_string(tag) + " (" +
                  names[static_cast<std::size_t>(tag)] +
                  ") and are taken as they are stored; if the camera was mounted so, have them "
                  "turned: set the orientation to apply, otherwise to ignore.");
  }
}

void check_settings(const std::vector<Photograph>& photographs) {
  struct Setting {
    const char* name;
    const char* fix;
    std::optional<double> io::PhotoSettings::*value;
  };
  const Setting settings[] = {
      {"aperture f/", "it changes light and vignetting: photograph everything at one aperture",
       &io::PhotoSettings::f_number},
      {"sensitivity ISO ", "it changes gain and noise: photograph everything at one sensitivity",
       &io::PhotoSettings::iso},
      {"focal length in mm ", "it changes the calibration: do not zoom or refocus within a session",
       &io::PhotoSettings::focal_length_mm}};
  const auto fail = [](const Photograph& odd, const std::string& what, const std::string& its,
                       const Photograph& first, const std::string& usual, const std::string& fix) {
    throw InputError(odd.path.string() + ": " + what + its + ", but " +
                     first.path.filename().string() + " and others have " + usual + "; " + fix +
                     ".");
  };
  for (const Setting& setting : settings) {
    // The value that most photographs have is the session's; the others are the odd ones.
    std::vector<std::pair<const Photograph*, int>> values;
    for (const Photograph& photograph : photographs) {
      const std::optional<double>& value = photograph.settings.*setting.value;
      if (!value) continue;
      const auto known = std::find_if(values.begin(), values.end(), [&](const auto& entry) {
        return !differ(*(entry.first->settings.*setting.value), *value);
      });
      if (known == values.end()) {
        values.emplace_back(&photograph, 1);
      } else {
        ++known->second;
      }
    }
    if (values.size() < 2) continue;
    std::stable_sort(values.begin(), values.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    const Photograph& usual = *values[0].first;
    const Photograph& odd = *values[1].first;
    fail(odd, setting.name, shown(*(odd.settings.*setting.value)), usual,
         shown(*(usual.settings.*setting.value)), setting.fix);
  }
  const Photograph* first = nullptr;
  for (const Photograph& photograph : photographs) {
    const std::string& camera = photograph.settings.camera;
    if (camera.empty()) continue;
    if (first == nullptr) first = &photograph;
    if (camera != first->settings.camera) {
      fail(photograph, "camera ", "'" + camera + "'", *first, "'" + first->settings.camera + "'",
           "a session has one camera");
    }
  }
}

}  // namespace kappamu::capture
