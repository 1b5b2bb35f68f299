#include <algorithm>
#include <cmath>

#include "app/report/picture.h"
#include "app/report/sections.h"

namespace kappamu::app::report {

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

Html slices(const Volume<double>& volume, const std::string& symbol, const std::string& unit) {
  const std::vector<float> values(volume.values().begin(), volume.values().end());
  // The ends of the scale leave out single runaway voxels, and lie apart far enough that a constant
  // looks constant.
  const double middle = quantile(values, 0.5);
  const double low = std::min(quantile(values, 0.005), middle - least_span * std::abs(middle));
  const double high = std::max(quantile(values, 0.995), middle + least_span * std::abs(middle));
  std::vector<Html> blocks;
  for (const int z : depths(volume.shape().nz)) {
    const Image<float> image = reduced(slice(volume, z), slice_pixels);
    const double depth = (z + 0.5) * volume.shape().voxel_mm;
    blocks.push_back(figure(picture(coloured(image, ColourMap::viridis, low, high), slice_width,
                                    symbol + " at depth " + number(depth) + " mm"),
                            "z = " + number(depth) + " mm"));
  }
  blocks.push_back(legend(ColourMap::viridis, low, high, symbol + " [" + unit + "]", 160));
  return row(blocks);
}

}  // namespace

Html volumes_section(const RunData& run) {
  if (!run.fit || run.fit->media.empty())
    return section("Volumes", note("This run has no fitted volumes yet."));
  Html content;
  for (std::size_t c = 0; c < run.fit->media.size(); ++c) {
    const Medium& medium = run.fit->media[c];
    content += subsection("κ, diffusion coefficient, channel " + run.fit->channels[c],
                          slices(medium.kappa, "κ", "mm"));
    content += subsection("μ, absorption coefficient, channel " + run.fit->channels[c],
                          slices(medium.mu, "μ", "1/mm"));
  }
  content += note(
      "Slices across z, x to the right and y down, light entering at z = 0. Each block has its own "
      "scale, from the 0.5 % to the 99.5 % quantile. Continuous light does not determine κ and μ "
      "uniquely, least of all far from the surfaces: appearance under held-out light is what is "
      "judged.");
  return section("Volumes", content);
}

}  // namespace kappamu::app::report
