#include "pipeline/sfdi/sfdi_neighbours.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/shown_text.h"
#include "pipeline/sfdi/median.h"

namespace kappamu::pipeline::sfdi {

namespace {

// A change [log units] that matters, in how many standard deviations it is sure, and at which share
// of the pixels.
constexpr double least_change = 0.2, sure_deviations = 3.0, least_share = 0.02;

double median_of(const Image<float>& values) {
  std::vector<double> finite;
  for (const float value : values.values()) {
    if (std::isfinite(value)) finite.push_back(value);
  }
  return median(std::move(finite));
}

bool changes(const Image<float>& value, const Image<float>& deviation, std::pair<int, int> a,
             std::pair<int, int> b) {
  const double at_a = value(a.first, a.second), at_b = value(b.first, b.second);
  const double noise =
      std::hypot(deviation(a.first, a.second) / at_a, deviation(b.first, b.second) / at_b);
  return std::abs(std::log(at_a / at_b)) > std::max(least_change, sure_deviations * noise);
}

}  // namespace

std::optional<std::string> neighbours_warning(const WavelengthMap& map, double pixel_mm) {
  const double mua = median_of(map.mua), musp = median_of(map.musp);
  if (!(mua > 0.0) || !(pixel_mm > 0.0)) return std::nullopt;
  // Even light has spread by a diffusion length before it leaves.
  const double spread_mm = 1.0 / std::sqrt(3.0 * mua * (mua + musp));
  const int step = std::max(1, static_cast<int>(std::lround(spread_mm / pixel_mm)));
  const int width = map.mua.width(), height = map.mua.height();
  const auto valid = [&](int x, int y) {
    return x < width && y < height && map.verdict(x, y) == 0 && map.mua(x, y) > 0.0F;
  };
  std::size_t pixels = 0, changed = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!valid(x, y)) continue;
      bool has_neighbour = false, differs = false;
      for (const auto& [to_x, to_y] : {std::pair{x + step, y}, std::pair{x, y + step}}) {
        if (!valid(to_x, to_y)) continue;
        has_neighbour = true;
        differs = differs || changes(map.mua, map.mua_deviation, {x, y}, {to_x, to_y}) ||
                  changes(map.musp, map.musp_deviation, {x, y}, {to_x, to_y});
      }
      pixels += has_neighbour ? 1 : 0;
      changed += differs ? 1 : 0;
    }
  }
  if (pixels == 0) return std::nullopt;
  const double share = static_cast<double>(changed) / static_cast<double>(pixels);
  if (share < least_share) return std::nullopt;
  return map.label() + ": at " + shown_number(100.0 * share, "%.2g") +
         " % of the pixels a coefficient changes by over a fifth within " +
         shown_number(spread_mm, "%.2g") +
         " mm, as far as light spreads here, and a map takes each pixel for homogeneous. To take "
         "neighbours into account, fit a volume to bars or patches, from the map's medians: "
         "start_kappa " +
         shown_number(1.0 / (3.0 * (mua + musp)), "%.3g") + " mm, start_mu " +
         shown_number(mua, "%.3g") + " /mm.";
}

}  // namespace kappamu::pipeline::sfdi
