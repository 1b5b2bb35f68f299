// The uncertainty of a volume in words.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/shown_text.h"
#include "inverse/defaults.h"
#include "inverse/uncertainty/uncertainty.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::summary;

std::string number(double value) {
  return shown_number(value, "%.3g");
}

/// First and last layer that `holds` is true of, gaps included.
struct Range {
  std::size_t first = 0;
  std::size_t last = 0;
};
std::optional<Range> range_of(const std::vector<LayerUncertainty>& layers,
                              const std::function<bool(const LayerUncertainty&)>& holds) {
  const auto first = std::find_if(layers.begin(), layers.end(), holds);
  if (first == layers.end()) return std::nullopt;
  const auto last = std::find_if(layers.rbegin(), layers.rend(), holds);
  return Range{static_cast<std::size_t>(first - layers.begin()),
               static_cast<std::size_t>(layers.rend() - last) - 1};
}

/// "throughout", "beyond 2.5 mm below the seen face", "down to 1 mm ...", "between 1 and 2 mm ...".
std::string where(const std::vector<LayerUncertainty>& layers, const Range& range) {
  const double half = layers.front().depth_mm;  // of a voxel
  const double from = layers[range.first].depth_mm - half;
  const double to = layers[range.last].depth_mm + half;
  const bool at_face = range.first == 0;
  const bool to_end = range.last + 1 == layers.size();
  if (at_face && to_end) return "throughout the block";
  if (to_end) return "beyond " + number(from) + " mm below the seen face";
  if (at_face) return "down to " + number(to) + " mm below the seen face";
  return "between " + number(from) + " and " + number(to) + " mm below the seen face";
}

std::string coefficient_in_words(const std::vector<LayerUncertainty>& layers,
                                 const std::string& symbol, double LayerUncertainty::*deviation,
                                 double LayerUncertainty::*resolution) {
  const auto by_deviation = [&](const LayerUncertainty& a, const LayerUncertainty& b) {
    return a.*deviation < b.*deviation;
  };
  const auto [best, worst] = std::minmax_element(layers.begin(), layers.end(), by_deviation);
  std::string text = symbol + " is determined within a factor of " +
                     number(std::exp((*best).*deviation)) + " at best (" + number(best->depth_mm) +
                     " mm below the seen face) and " + number(std::exp((*worst).*deviation)) +
                     " at worst (" + number(worst->depth_mm) + " mm).";
  const auto loose = range_of(layers, [&](const LayerUncertainty& layer) {
    return layer.*deviation >= std::log(undetermined_factor);
  });
  if (loose) {
    text += " The data determine " + symbol + " to no better than a factor of " +
            number(undetermined_factor) + " " + where(layers, *loose) + ".";
  }
  const auto silent = range_of(
      layers, [&](const LayerUncertainty& layer) { return layer.*resolution < decided_by_data; });
  if (silent) {
    text += " The smoothing, not the data, decides most of " + symbol + " " +
            where(layers, *silent) + ".";
  }
  return text;
}

/// "1 to 3.3 mm", "up to 3.3 mm" where some of it is a voxel's.
std::string widths_in_words(const std::vector<LayerUncertainty>& layers,
                            double LayerUncertainty::*width) {
  const auto narrower = [&](const LayerUncertainty& a, const LayerUncertainty& b) {
    return a.*width < b.*width;
  };
  const auto [least, most] = std::minmax_element(layers.begin(), layers.end(), narrower);
  const std::string to = number((*most).*width) + " mm";
  if ((*least).*width == 0.0) return "up to " + to;
  return (*least).*width == (*most).*width ? to : number((*least).*width) + " to " + to;
}

}  // namespace

std::string in_words(const std::vector<LayerUncertainty>& layers) {
  if (layers.empty()) return {};
  std::string text = coefficient_in_words(layers, "κ", &LayerUncertainty::log_kappa_std,
                                          &LayerUncertainty::kappa_resolution) +
                     " " +
                     coefficient_in_words(layers, "μ", &LayerUncertainty::log_mu_std,
                                          &LayerUncertainty::mu_resolution);
  const auto traded = range_of(
      layers, [](const LayerUncertainty& layer) { return std::abs(layer.correlation) >= trading; });
  if (traded) {
    const auto strongest = std::max_element(
        layers.begin(), layers.end(), [](const LayerUncertainty& a, const LayerUncertainty& b) {
          return std::abs(a.correlation) < std::abs(b.correlation);
        });
    text += " κ and μ trade against each other " + where(layers, *traded) + " (correlation up to " +
            number(strongest->correlation) + "): their combination is better known than either.";
  }
  if (std::any_of(layers.begin(), layers.end(), [](const LayerUncertainty& layer) {
        return layer.kappa_fwhm_mm > 0.0 || layer.mu_fwhm_mm > 0.0;
      })) {
    text += " These are deviations of what the light resolves, means over " +
            widths_in_words(layers, &LayerUncertainty::kappa_fwhm_mm) + " of κ and " +
            widths_in_words(layers, &LayerUncertainty::mu_fwhm_mm) +
            " of μ; finer structure does not show.";
  }
  return text;
}

}  // namespace kappamu::inverse
