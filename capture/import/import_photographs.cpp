#include "capture/import/import_photographs.h"

#include <algorithm>
#include <charconv>
#include <regex>
#include <set>

#include "capture/session/frames.h"
#include "capture/session/session_files.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/image/image_file.h"
#include "io/image/raw_file.h"
#include "io/read_file.h"
#include "io/text_stream.h"

namespace kappamu::capture {
namespace {

namespace fs = std::filesystem;

// Cameras round the numbers they write.
constexpr double equal_settings = 0.02;

bool is_photograph(const fs::path& file) {
  static const std::set<std::string> endings{".png", ".tif", ".tiff", ".jpg", ".jpeg", ".exr"};
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

std::vector<fs::path> photographs_below(const fs::path& folder, Progress& progress) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw InputError(folder.string() + ": no such folder; give the folder of the photographs.");
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& file = entry.path();
    // Pattern images lie in a folder of their own and are no photographs.
    if (file.parent_path().filename() == "patterns" || !entry.is_regular_file()) continue;
    if (is_photograph(file)) files.push_back(file);
  }
  std::sort(files.begin(), files.end());
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

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  std::istringstream in = io::text_reader(line);
  while (std::getline(in, cell, ',')) {
    const auto begin = cell.find_first_not_of(" \t\r\"");
    const auto end = cell.find_last_not_of(" \t\r\"");
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
  }
  return cells;
}

double seconds_in(const std::string& text, const std::string& where) {
  // 1/30 is how cameras and people write it.
  double value = 0.0;
  double divisor = 1.0;
  const char* end = text.data() + text.size();
  auto read = std::from_chars(text.data(), end, value);
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == '/') {
    read = std::from_chars(read.ptr + 1, end, divisor);
  }
  if (read.ec != std::errc() || read.ptr != end || !(value / divisor > 0.0)) {
    throw InputError(where + ": '" + shown_name(text) +
                     "' is no exposure time; write seconds, such as 0.5 or 1/30.");
  }
  return value / divisor;
}

std::vector<Photograph> from_table(const PhotographSource& source) {
  const fs::path& table = *source.table;
  std::istringstream lines = io::text_reader(io::read_text(table));
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> header = split(line);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  };
  const std::size_t file = column("file");
  const std::size_t shot = column("shot");
  const std::size_t exposure = column("exposure_s");
  if (file == header.size() || shot == header.size()) {
    throw InputError(table.string() +
                     ": the first line must name the columns file and shot and, where EXIF does "
                     "not tell, exposure_s.");
  }
  std::vector<Photograph> photographs;
  for (int number = 2; std::getline(lines, line); ++number) {
    const std::vector<std::string> cells = split(line);
    if (cells.empty()) continue;
    const std::string where = table.string() + ": line " + std::to_string(number);
    if (cells.size() <= std::max(file, shot)) {
      throw InputError(where + " has " + std::to_string(cells.size()) +
                       " cells, the first line has " + std::to_string(header.size()) + ".");
    }
    if (!stays_inside(cells[file])) {
      throw InputError(where + ": '" + shown_name(cells[file]) +
                       "' leaves the photographs' folder; write file names relative to it.");
    }
    require_plain_name(cells[shot], where + ": the shot");
    Photograph photograph;
    photograph.path = source.folder / cells[file];
    photograph.shot = cells[shot];
    std::error_code ignored;
    if (!fs::is_regular_file(photograph.path, ignored)) {
      throw InputError(where + ": " + photograph.path.string() + ": no such photograph.");
    }
    if (exposure < cells.size() && !cells[exposure].empty()) {
      photograph.exposure_s = seconds_in(cells[exposure], where);
    }
    photographs.push_back(std::move(photograph));
  }
  if (photographs.empty()) throw InputError(table.string() + ": lists no photographs.");
  return photographs;
}

std::string shown(double value) {
  return shown_number(value, "%.4g");
}

bool differ(double a, double b) {
  return std::abs(a - b) > equal_settings * std::max(a, b);
}

}  // namespace

std::vector<Photograph> find_photographs(const PhotographSource& source, Progress& progress) {
  std::vector<Photograph> photographs;
  if (source.table) {
    photographs = from_table(source);
  } else {
    for (const fs::path& file : photographs_below(source.folder, progress)) {
      photographs.push_back({file, shot_of(file), {}, 0.0});
    }
  }
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    Photograph& photograph = photographs[i];
    if (source.links == Links::within) {
      require_inside(source.folder, photograph.path.lexically_relative(source.folder));
    }
    progress.update("import", 0.3 * static_cast<double>(i) / photographs.size(),
                    photograph.path.filename().string());
    photograph.settings = io::read_photo_settings(photograph.path);
    const std::optional<double>& exif_s = photograph.settings.exposure_s;
    if (photograph.exposure_s > 0.0 && exif_s && differ(photograph.exposure_s, *exif_s)) {
      throw InputError(photograph.path.string() + ": the table says " +
                       shown(photograph.exposure_s) + " s, EXIF says " + shown(*exif_s) +
                       " s; correct the table, or leave its exposure_s empty.");
    }
    if (photograph.exposure_s == 0.0) photograph.exposure_s = exif_s.value_or(0.0);
  }
  std::sort(photographs.begin(), photographs.end(), [](const Photograph& a, const Photograph& b) {
    return std::tie(a.shot, a.exposure_s, a.path) < std::tie(b.shot, b.exposure_s, b.path);
  });
  return photographs;
}

void require_exposure_times(const std::vector<Photograph>& photographs) {
  for (const Photograph& photograph : photographs) {
    if (photograph.exposure_s == 0.0) {
      throw InputError(photograph.path.string() +
                       ": neither EXIF nor a table states its exposure time; give a CSV with the "
                       "columns file, shot, exposure_s (--table).");
    }
  }
}

void read_camera(const fs::path& photograph, Camera& camera) {
  if (is_headerless(camera, photograph)) return;
  if (io::is_raw_file(photograph)) {
    const io::RawImage raw = io::read_raw(photograph);
    camera.width = raw.mosaic.width();
    camera.height = raw.mosaic.height();
    camera.encoding = Encoding::linear;
    camera.white_level = raw.white;
    camera.bit_depth = 8;
    while (raw.white >> camera.bit_depth != 0) ++camera.bit_depth;
    return;
  }
  camera.white_level.reset();
  if (is_float_frame({photograph.string(), 0.0})) {
    const Image<float> image = io::read_float_image(photograph);
    camera.width = image.width();
    camera.height = image.height();
    camera.encoding = Encoding::linear;
    return;
  }
  const Image<std::uint16_t> image = io::read_code_image(photograph);
  camera.width = image.width();
  camera.height = image.height();
  const std::string ending = photograph.extension().string();
  if (ending.size() > 1 && (ending[1] == 'j' || ending[1] == 'J')) {
    camera.bit_depth = 8;  // JPEG: eight bits behind a tone curve
    camera.encoding = Encoding::response;
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
