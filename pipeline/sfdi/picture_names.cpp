#include "pipeline/sfdi/picture_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/image/image_file.h"
#include "io/image/image_limits.h"
#include "io/mat_file.h"
#include "io/npy.h"

namespace kappamu::pipeline::sfdi {

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 10> picture_endings{".png", ".tif", ".tiff", ".jpg", ".jpeg",
                                                           ".bmp", ".exr", ".hdr",  ".npy", ".mat"};

constexpr std::array<std::string_view, 8> video_endings{".avi", ".mp4", ".m4v",  ".mov",
                                                        ".mkv", ".wmv", ".webm", ".mpg"};

constexpr std::size_t most_pages = 10'000;

/// A name taken apart.
struct Name {
  fs::path file;
  std::string variable;  ///< of a MATLAB file
  std::optional<std::size_t> page;
};

bool is_tiff(const fs::path& file) {
  const std::string ending = lower_extension(file);
  return ending == ".tif" || ending == ".tiff";
}

std::optional<std::size_t> whole_number(const std::string& text) {
  if (text.empty() || text.size() > 9 ||
      text.find_first_not_of("0123456789") != std::string::npos) {
    return {};
  }
  return std::stoul(text);
}

Name parsed(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  if (fs::exists(folder / name, ignored)) return {folder / name, "", {}};  // with its colons
  for (const char* ending : {".mat:", ".tif:", ".tiff:", ".npy:"}) {
    const std::size_t found = name.find(ending);
    if (found == std::string::npos) continue;
    const std::size_t colon = found + std::string_view(ending).size() - 1;
    Name result{folder / name.substr(0, colon), "", {}};
    std::string rest = name.substr(colon + 1);
    const bool mat = std::string_view(ending) == ".mat:";
    if (mat) {
      const std::size_t second = rest.find(':');
      result.variable = rest.substr(0, second);
      if (second == std::string::npos) return result;
      rest = rest.substr(second + 1);
    }
    result.page = whole_number(rest);
    if (!result.page) {
      throw InputError((folder / name).string() + ": a page is named as " +
                       (mat ? "FILE.mat:VARIABLE:NUMBER" : "FILE:NUMBER") + ", from 0");
    }
    return result;
  }
  return {folder / name, "", {}};
}

/// The last run of digits in a name without its ending.
std::optional<std::size_t> last_number(const fs::path& file) {
  const std::string stem = file.stem().string();
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  const auto end = std::find_if(stem.rbegin(), stem.rend(), digit).base();
  auto begin = end;
  while (begin != stem.begin() && digit(*(begin - 1))) --begin;
  return whole_number({begin, end});
}

std::vector<std::string> frames_of(const fs::path& folder, const std::string& name) {
  const std::string where = (folder / name).string() + ": ";
  std::map<std::size_t, std::string> frames;
  std::string ending;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder / name)) {
    const fs::path file = entry.path();
    const std::string its_ending = lower_extension(file);
    std::error_code ignored;
    if (fs::is_directory(file, ignored) || file.filename().string().starts_with('.') ||
        std::find(picture_endings.begin(), picture_endings.end(), its_ending) ==
            picture_endings.end()) {
      continue;
    }
    if (!fs::is_regular_file(file, ignored)) {
      throw InputError(
          file.string() +
          ": is no file, or a symbolic link that leads to none; put the picture back or "
          "take it out");
    }
    if (!ending.empty() && its_ending != ending) {
      throw InputError(where + "holds pictures that end in " + ending + " and in " + its_ending +
                       "; leave those of one measurement there");
    }
    ending = its_ending;
    const std::string shown = shown_name(file.filename().string());
    const auto number = last_number(file);
    if (!number) throw InputError(where + shown + " has no number; number the frames in order");
    const auto [other, added] =
        frames.emplace(*number, (fs::path(name) / file.filename()).string());
    if (!added) {
      throw InputError(where + shown + " and " +
                       shown_name(fs::path(other->second).filename().string()) +
                       " have the same number; leave one of them there");
    }
  }
  if (frames.empty()) throw InputError(where + "the folder holds no picture");
  const std::size_t first = frames.begin()->first, last = frames.rbegin()->first;
  if (last - first + 1 != frames.size()) {
    std::size_t missing = first;
    while (frames.count(missing) != 0) ++missing;
    throw InputError(where + "frame " + std::to_string(missing) + " is missing between " +
                     std::to_string(first) + " and " + std::to_string(last) +
                     "; name the pictures one by one if that is meant");
  }
  std::vector<std::string> names;
  for (auto& [number, frame] : frames) names.push_back(std::move(frame));
  return names;
}

Image<float> read_array(const fs::path& file, const std::optional<std::size_t>& page) {
  const std::vector<std::size_t> shape = io::read_npy_layout(file).shape;
  const bool stack = shape.size() == 3;
  if (shape.size() != 2 && !stack) {
    throw InputError(file.string() + ": array has shape " + io::shape_to_string(shape) +
                     "; a picture is [y][x], several are [page][y][x]");
  }
  const std::size_t height = shape[stack ? 1 : 0], width = shape[stack ? 2 : 1];
  const std::size_t pages = stack ? shape[0] : 1, at = page.value_or(0);
  if (height == 0 || width == 0 || height > io::most_image_values / width ||
      pages > io::most_image_values / (height * width)) {
    throw InputError(file.string() + ": array has shape " + io::shape_to_string(shape) +
                     "; at most " + std::to_string(io::most_image_values) + " numbers are read");
  }
  if (at >= pages) {
    throw InputError(file.string() + ": has pages 0 to " + std::to_string(pages - 1) +
                     ", no page " + std::to_string(at));
  }
  Image<float> picture(static_cast<int>(width), static_cast<int>(height), 1);
  picture.values() = io::read_npy_part(file, at * height * width, height * width);
  return picture;
}

}  // namespace

std::vector<std::string> pictures_named(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  if (fs::is_directory(folder / name, ignored)) return frames_of(folder, name);
  const Name one = parsed(folder, name);
  if (one.page || !fs::is_regular_file(one.file, ignored)) return {name};
  const std::string ending = lower_extension(one.file);
  std::size_t pages = 1;
  std::string stem = name;
  if (ending == ".mat") {
    pages = io::count_mat_pages(one.file, one.variable);
    if (one.variable.empty()) stem += ":";
  } else if (ending == ".npy") {
    const std::vector<std::size_t> shape = io::read_npy_layout(one.file).shape;
    if (shape.size() == 3) pages = shape[0];
  } else if (is_tiff(one.file)) {
    pages = io::TiffPages(one.file).count();
  }
  if (pages == 1) return {name};
  if (pages == 0 || pages > most_pages) {
    throw InputError(one.file.string() + ": holds " + std::to_string(pages) +
                     " pictures; from 1 to " + std::to_string(most_pages) + " are read");
  }
  std::vector<std::string> names;
  for (std::size_t page = 0; page < pages; ++page) {
    names.push_back(stem + ":" + std::to_string(page));
  }
  return names;
}

io::TiffPages& PictureReader::pages_of(const fs::path& file) {
  const auto found = stacks_.find(file);
  if (found != stacks_.end()) return found->second;
  std::size_t held = 0;
  for (const auto& [other, pages] : stacks_) held += pages.bytes();
  std::error_code ignored;
  if (held + fs::file_size(file, ignored) > io::largest_image_file) stacks_.clear();
  return stacks_.try_emplace(file, file).first->second;
}

Image<float> PictureReader::read(const fs::path& folder, const std::string& name) {
  const Name one = parsed(folder, name);
  const std::string ending = lower_extension(one.file);
  if (ending == ".mat") return io::read_mat_picture(one.file, one.variable, one.page.value_or(0));
  if (ending == ".npy") return read_array(one.file, one.page);
  if (one.page) return pages_of(one.file).read(*one.page);
  if (std::find(video_endings.begin(), video_endings.end(), ending) != video_endings.end()) {
    throw InputError(one.file.string() +
                     ": is a video; let a program such as ffmpeg write its frames as numbered "
                     "pictures into a folder, and name the folder");
  }
  if (io::is_float_image(one.file)) return io::read_float_image(one.file);
  const Image<std::uint16_t> codes = io::read_code_image(one.file);
  Image<float> picture(codes.width(), codes.height(), codes.channels());
  std::copy(codes.values().begin(), codes.values().end(), picture.values().begin());
  return picture;
}

}  // namespace kappamu::pipeline::sfdi
