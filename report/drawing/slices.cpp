#include "report/drawing/slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/image.h"
#include "report/drawing/picture.h"

namespace kappamu::report {

namespace {

constexpr int slices_stored = 8;     // of each axis
constexpr double least_span = 0.01;  // of the scale, relative to the middle, to either side
constexpr int slice_pixels = 112;    // longest side of a stored picture
constexpr int longest_edge = 260;    // CSS px of the block's longest edge
constexpr int layer_pixels = 1024;   // longest side of a single layer
constexpr int layer_edge = 780;      // CSS px

struct Across {
  const char* name;
  int axis, right, down;
};
constexpr std::array<Across, 3> directions{{{"z", 2, 0, 1}, {"x", 0, 2, 1}, {"y", 1, 0, 2}}};

Image<float> slice(const Volume<double>& volume, const Across& across, int at) {
  const GridShape& shape = volume.shape();
  Image<float> image(shape.extent(across.right), shape.extent(across.down), 1);
  std::array<int, 3> voxel{};
  voxel[static_cast<std::size_t>(across.axis)] = at;
  for (int row = 0; row < image.height(); ++row) {
    for (int column = 0; column < image.width(); ++column) {
      voxel[static_cast<std::size_t>(across.right)] = column;
      voxel[static_cast<std::size_t>(across.down)] = row;
      image(column, row) = static_cast<float>(volume(voxel[0], voxel[1], voxel[2]));
    }
  }
  return image;
}

/// Spread evenly from the first layer to the last.
std::vector<int> layers(int extent) {
  const int count = std::min(extent, slices_stored);
  std::vector<int> result;
  for (int i = 0; i < count; ++i) result.push_back((2 * i + 1) * extent / (2 * count));
  return result;
}

/// The ends of the scale leave out single runaway voxels, and lie apart far enough that a constant
/// looks constant.
std::pair<double, double> scale_of(const std::vector<float>& values) {
  const double middle = quantile(values, 0.5), least = least_span * std::abs(middle);
  return {std::min(quantile(values, 0.005), middle - least),
          std::max(quantile(values, 0.995), middle + least)};
}

std::string with_unit(const std::string& symbol, const std::string& unit) {
  return unit.empty() ? symbol : symbol + " [" + unit + "]";
}

}  // namespace

Html layer(const Image<float>& values, const std::string& symbol, const std::string& unit,
           const std::string& where) {
  const auto [low, high] = scale_of(values.values());
  const int longest = std::max(values.width(), values.height());
  const int width = std::max(layer_edge * values.width() / longest, 8);
  return row({figure(picture(coloured(reduced(values, layer_pixels), ColourMap::viridis, low, high),
                             width, symbol + " at " + where),
                     where),
              legend(ColourMap::viridis, low, high, with_unit(symbol, unit), 160)});
}

Html slices(const Volume<double>& volume, const std::string& symbol, const std::string& unit,
            std::optional<std::pair<double, double>> range) {
  const auto [low, high] =
      range ? *range : scale_of({volume.values().begin(), volume.values().end()});
  const GridShape& shape = volume.shape();
  const int longest = std::max({shape.nx, shape.ny, shape.nz});
  std::vector<Html> blocks;
  for (const Across& across : directions) {
    const std::vector<int> stored = layers(shape.extent(across.axis));
    Html stack;
    for (std::size_t i = 0; i < stored.size(); ++i) {
      const Image<float> image = slice(volume, across, stored[i]);
      const std::string where =
          std::string(across.name) + " = " + number((stored[i] + 0.5) * shape.voxel_mm) + " mm";
      const int width = std::max(longest_edge * image.width() / longest, 8);
      stack += element(
          "div", {{"class", i == stored.size() / 2 ? "shown" : ""}},
          figure(picture(coloured(reduced(image, slice_pixels), ColourMap::viridis, low, high),
                         width, symbol + " at " + where),
                 where));
    }
    blocks.push_back(element("div", {{"class", "stack"}}, stack));
  }
  blocks.push_back(legend(ColourMap::viridis, low, high, with_unit(symbol, unit), 160));
  return row(blocks);
}

const char* const slider_script =
    R"(document.getElementById("slider").addEventListener("input", function (event) {
  document.querySelectorAll(".stack").forEach(function (stack) {
    var count = stack.children.length, at = Math.min(count - 1, Math.floor(event.target.value * count));
    for (var i = 0; i < count; ++i) stack.children[i].className = i === at ? "shown" : "";
  });
});)";
const char* const slider_script_sha256 = "rfMYxxyIG4QVm8KkHW1rsVuG4A2Ni/eLJY5OUkhOyJU=";

Html slice_slider() {
  return element(
      "label", {{"class", "slider"}},
      text("slices from the first layer to the last") + empty_element("input", {{"id", "slider"},
                                                                                {"type", "range"},
                                                                                {"min", "0"},
                                                                                {"max", "0.999"},
                                                                                {"step", "0.001"},
                                                                                {"value", "0.5"}}));
}

}  // namespace kappamu::report
