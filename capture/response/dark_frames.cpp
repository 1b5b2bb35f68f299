#include "capture/response/dark_frames.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "capture/session/frames.h"

namespace kappamu::capture {
namespace {

constexpr double outlier_deviations = 5.0;
constexpr double clipped_share = 1.0 / 6.0;  // below one standard deviation under the mean

struct Moments {
  double mean = 0.0;
  double deviation = 0.0;
};

Moments moments(const std::vector<long>& histogram, double low, double high) {
  double count = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t code = 0; code < histogram.size(); ++code) {
    const auto value = static_cast<double>(code);
    if (value < low || value > high) continue;
    const auto times = static_cast<double>(histogram[code]);
    count += times;
    sum += times * value;
    squares += times * value * value;
  }
  if (count == 0.0) return {};
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(squares / count - mean * mean, 0.0))};
}

std::size_t quantile(const std::vector<long>& histogram, double share) {
  const auto total = static_cast<double>(std::accumulate(histogram.begin(), histogram.end(), 0L));
  double below = 0.0;
  for (std::size_t code = 0; code < histogram.size(); ++code) {
    below += static_cast<double>(histogram[code]);
    if (below >= share * total) return code;
  }
  return histogram.size() - 1;
}

}  // namespace

DarkLevel dark_level(const std::vector<long>& histogram) {
  const auto median = static_cast<double>(quantile(histogram, 0.5));
  const double upper = static_cast<double>(quantile(histogram, 0.8413)) - median;
  const auto total = static_cast<double>(std::accumulate(histogram.begin(), histogram.end(), 0L));
  if (static_cast<double>(histogram.front()) > clipped_share * total) return {median, upper};
  const double reach = outlier_deviations * std::max(upper, 1.0);
  Moments found = moments(histogram, median - reach, median + reach);
  const double narrower = outlier_deviations * std::max(found.deviation, 0.5);
  found = moments(histogram, found.mean - narrower, found.mean + narrower);
  return {found.mean, found.deviation};
}

std::vector<DarkLevel> dark_levels(const Session& session) {
  const std::size_t channels = session.channels.size();
  std::vector<std::vector<long>> histograms(
      channels, std::vector<long>(static_cast<std::size_t>(largest_code(session.camera)) + 1, 0));
  for (const Frame& frame : session.calibration.dark) {
    const Image<std::uint16_t> codes = load_sites(session, frame);
    for (std::size_t i = 0; i < codes.size(); ++i) {
      ++histograms[i % channels][codes.values()[i]];
    }
  }
  std::vector<DarkLevel> levels;
  levels.reserve(histograms.size());
  for (const auto& histogram : histograms) levels.push_back(dark_level(histogram));
  return levels;
}

}  // namespace kappamu::capture
