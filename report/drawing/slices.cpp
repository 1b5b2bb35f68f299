#include "report/drawing/slices.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/image.h"
#include "report/drawing/picture.h"

namespace kappamu::report {

namespace {

constexpr int slices_shown = 5;
constexpr double least_span = 0.01;  // of the scale, relative to the middle, to either side
constexpr int slice_pixels = 160;    // longest side of the stored picture
constexpr int slice_width = 168;     // CSS px: five and the legend fill the page's width

Image<float> slice(const Volume<double>& volume, int z) {
  const GridShape& shape = volume.shape();
  Image<float> image(shape.nx, shape.ny, 1);
  for (int y = 0; y < shape.ny; ++y)
    for (int x = 0; x < shape.nx; ++x) image(x, y) = static_cast<float>(volume(x, y, z));
  return image;
}

/// Depths spread evenly from the first layer to the last.
std::vector<int> depths(int nz) {
  const int count = std::min(nz, slices_shown);
  std::vector<int> result;
  result.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    result.push_back(count == 1 ? nz / 2 : (i * (nz - 1) + (count - 1) / 2) / (count - 1));
  return result;
}

}  // namespace

Html slices(const Volume<double>& volume, const std::string& symbol, const std::string& unit,
            std::optional<std::pair<double, double>> range) {
  const std::vector<float> values(volume.values().begin(), volume.values().end());
  // The ends of the scale leave out single runaway voxels, and lie apart far enough that a constant
  // looks constant.
  const double middle = quantile(values, 0.5);
  const double low =
      range ? range->first
            : std::min(quantile(values, 0.005), middle - least_span * std::abs(middle));
  const double high =
      range ? range->second
            : std::max(quantile(values, 0.995), middle + least_span * std::abs(middle));
  std::vector<Html> blocks;
  for (const int z : depths(volume.shape().nz)) {
    const Image<float> image = reduced(slice(volume, z), slice_pixels);
    const double depth = (z + 0.5) * volume.shape().voxel_mm;
    blocks.push_back(figure(picture(coloured(image, ColourMap::viridis, low, high), slice_width,
                                    symbol + " at depth " + number(depth) + " mm"),
                            "z = " + number(depth) + " mm"));
  }
  blocks.push_back(legend(ColourMap::viridis, low, high,
                          unit.empty() ? symbol : symbol + " [" + unit + "]", 160));
  return row(blocks);
}

}  // namespace kappamu::report
