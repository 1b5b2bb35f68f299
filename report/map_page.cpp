#include "report/map_page.h"

#include <algorithm>
#include <cmath>

#include "core/shown_text.h"
#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "report/drawing/html.h"
#include "report/drawing/page.h"
#include "report/drawing/picture.h"

namespace kappamu::report {

namespace {

namespace sfdi = pipeline::sfdi;

constexpr int gap = 8;  ///< between the maps of the picture [px]

/// Colours from the value a fiftieth of the pixels lie below to the one as many lie above, widened
/// where a map is flat.
struct Range {
  double low = 0.0, high = 1.0;
};
Range range_of(const Image<float>& map) {
  const double low = quantile(map.values(), 0.02), high = quantile(map.values(), 0.98);
  const double middle = 0.5 * (low + high);
  const double half = std::max(0.5 * (high - low), 0.05 * std::abs(middle));
  return {low < 0.0 ? middle - half : std::max(0.0, middle - half), middle + half};
}

Image<std::uint8_t> drawn(const Image<float>& map) {
  const Range range = range_of(map);
  return coloured(map, ColourMap::viridis, range.low, range.high);
}

Html map_figure(const Image<float>& map, const std::string& name, const std::string& unit) {
  const Range range = range_of(map);
  const Image<float> shown = reduced(map, 512);
  return figure(picture(coloured(shown, ColourMap::viridis, range.low, range.high), 360, name) +
                    legend(ColourMap::viridis, range.low, range.high, unit),
                name);
}

Html parts_table(const sfdi::WavelengthMap& map) {
  std::vector<std::vector<Html>> rows;
  for (const auto& [name, part] : sfdi::part_names) {
    const auto& parts = map.parts[static_cast<std::size_t>(part)];
    rows.push_back({text(name), text(percent(parts[0], 2)), text(percent(parts[1], 2))});
  }
  return subsection("Standard deviation of the median pixel by cause",
                    table({"cause", "μa", "σs'"}, rows));
}

Html checks_table(const sfdi::WavelengthMap& map) {
  std::vector<std::vector<Html>> rows;
  for (const sfdi::LightCheck& check : map.checks) {
    rows.push_back({text(number(check.per_mm) + " /mm"),
                    text(check.found_per_mm ? number(*check.found_per_mm, 4) + " /mm" : ""),
                    text(percent(check.second_harmonic, 2)), text(percent(check.stripes, 2)),
                    text(std::to_string(check.saturated))});
  }
  return subsection(
      "Sample's pictures",
      table({"frequency", "found", "second harmonic", "stripes left", "saturated pixels"}, rows));
}

Html wavelength_section(const sfdi::WavelengthMap& map) {
  Html content = row({map_figure(map.mua, "absorption μa", "1/mm"),
                      map_figure(map.musp, "reduced scattering σs'", "1/mm"),
                      map_figure(map.mua_deviation, "standard deviation of μa", "1/mm"),
                      map_figure(map.musp_deviation, "standard deviation of σs'", "1/mm")});
  if (!map.height_mm.empty()) content += row({map_figure(map.height_mm, "height", "mm")});
  if (map.region) {
    const sfdi::RegionMean& r = *map.region;
    content += paragraph("Mean of the region's " + std::to_string(r.pixels) + " pixels: μa " +
                         number(r.mean.mua) + " ± " + number(r.deviation[0], 2) + " /mm, σs' " +
                         number(r.mean.musp) + " ± " + number(r.deviation[1], 2) + " /mm.");
  }
  content += row({parts_table(map), checks_table(map)});
  return section(map.label(), content);
}

Html spectral_section(const sfdi::Maps& maps) {
  if (maps.spectral.empty()) return {};
  Html content;
  for (const sfdi::SpectralMap& map : maps.spectral) {
    content += row({map_figure(map.value, map.name, map.unit),
                    map_figure(map.deviation, "standard deviation of " + map.name, map.unit)});
  }
  return section("All wavelengths together", content);
}

}  // namespace

void write_map_picture(const sfdi::Maps& maps, const std::filesystem::path& file) {
  const int width = maps.wavelengths.front().mua.width();
  const int height = maps.wavelengths.front().mua.height();
  const auto rows = static_cast<int>(maps.wavelengths.size());
  Image<std::uint8_t> all(2 * width + gap, rows * (height + gap) - gap, 3, 255);
  for (int row = 0; row < rows; ++row) {
    const sfdi::WavelengthMap& map = maps.wavelengths[static_cast<std::size_t>(row)];
    for (const int column : {0, 1}) {
      const Image<std::uint8_t> one = drawn(column == 0 ? map.mua : map.musp);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          for (int c = 0; c < 3; ++c) {
            all(column * (width + gap) + x, row * (height + gap) + y, c) = one(x, y, c);
          }
        }
      }
    }
  }
  io::write_image(file, all);
}

void write_map_page(const sfdi::Maps& maps, const std::filesystem::path& file) {
  Html content = element("h1", text("kappamu map"));
  for (const std::string& warning : maps.warnings) content += paragraph(warning);
  for (const sfdi::WavelengthMap& map : maps.wavelengths) content += wavelength_section(map);
  content += spectral_section(maps);
  content += note(
      "Grey pixels are not valid. Colours reach from the second to the 98th of a "
      "hundred pixels in order.");
  io::write_text_atomically(file, whole_page("kappamu map", content).markup());
}

}  // namespace kappamu::report
