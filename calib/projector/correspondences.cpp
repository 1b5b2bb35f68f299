#include "calib/projector/correspondences.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/csv_table.h"
#include "io/image/image_limits.h"
#include "io/npy.h"

namespace kappamu::calib {
namespace {

namespace fs = std::filesystem;

bool inside(double place, int extent) {
  return place >= -0.5 && place <= extent - 0.5;
}

void read_table(const fs::path& file, const capture::Projector& projector, ProjectorMap& map) {
  const auto take = [&](const std::vector<std::string>& cells, const std::string& where) {
    std::array<double, 4> values{};
    bool good = true;
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::optional<double> value = io::csv_number(cells[k]);
      good &= value.has_value();
      values[k] = value.value_or(0.0);
    }
    const auto [x, y, column, row] = values;
    const bool whole = x == std::floor(x) && y == std::floor(y);
    if (!good || !whole || !inside(x, map.quality.width()) || !inside(y, map.quality.height()) ||
        !inside(column, projector.width) || !inside(row, projector.height)) {
      throw InputError(where +
                       " does not hold a camera pixel x, y and the projector's column, row that "
                       "it sees, both in their frames; correct it or take it out");
    }
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    map.pixel(i, j, 0) = static_cast<float>(column);
    map.pixel(i, j, 1) = static_cast<float>(row);
    map.quality(i, j) = 1.0F;
  };
  io::read_csv(file, {{"x"}, {"y"}, {"column"}, {"row"}}, take, io::largest_image_file);
}

void read_array(const fs::path& file, const capture::Projector& projector, ProjectorMap& map) {
  const auto width = static_cast<std::size_t>(map.quality.width());
  const auto height = static_cast<std::size_t>(map.quality.height());
  const io::NpyArray array = io::read_npy(file, {height, width, 2});
  for (std::size_t k = 0; k < width * height; ++k) {
    const float column = array.values[2 * k], row = array.values[2 * k + 1];
    if (!std::isfinite(column) || !std::isfinite(row)) continue;
    if (!inside(column, projector.width) || !inside(row, projector.height)) {
      throw InputError(file.string() + ": camera pixel (" + std::to_string(k % width) + ", " +
                       std::to_string(k / width) + ") sees projector pixel (" +
                       shown_number(column, "%g") + ", " + shown_number(row, "%g") +
                       "), which is outside its " + std::to_string(projector.width) + " x " +
                       std::to_string(projector.height) + "; write NaN where nothing was found");
    }
    map.pixel.values()[2 * k] = column;
    map.pixel.values()[2 * k + 1] = row;
    map.quality.values()[k] = 1.0F;
  }
}

}  // namespace

ProjectorMap read_correspondences(const fs::path& file, const capture::Camera& camera,
                                  const capture::Projector& projector) {
  ProjectorMap map{Image<float>(camera.width, camera.height, 2),
                   Image<float>(camera.width, camera.height, 1)};
  const std::string ending = lower_extension(file);
  if (ending == ".csv") {
    read_table(file, projector, map);
  } else if (ending == ".npy") {
    read_array(file, projector, map);
  } else {
    throw InputError(file.string() + ": correspondences are a .csv or a .npy file");
  }
  if (map.legible_share() == 0.0) {
    throw InputError(file.string() + ": holds no correspondence");
  }
  return map;
}

}  // namespace kappamu::calib
