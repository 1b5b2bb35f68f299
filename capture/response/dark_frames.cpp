#include "capture/response/dark_frames.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "capture/response/response.h"
#include "capture/session/frames.h"
#include "capture/session/frames_at_once.h"
#include "core/numbers/median.h"
#include "core/parallel.h"

namespace kappamu::capture {
namespace {

constexpr double outlier_deviations = 5.0;
constexpr double deviations_per_median_distance = 1.4826;  // of a normal distribution
constexpr double rounding = 0.29;                          // 1/√12 codes
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

std::vector<std::vector<long>> histograms_of(const Session& session, const Stack& frames) {
  const std::size_t channels = session.channels.size();
  std::vector<std::vector<long>> histograms(
      channels, std::vector<long>(static_cast<std::size_t>(largest_code(session.camera)) + 1, 0));
  std::mutex adding;
  const auto add = [&](int j) {
    const Image<std::uint16_t> codes = load_sites(session, frames[static_cast<std::size_t>(j)]);
    std::vector<std::vector<long>> own(channels, std::vector<long>(histograms.front().size(), 0));
    const std::uint16_t* code = codes.values().data();
    for (std::size_t pixel = 0; pixel < codes.size() / channels; ++pixel) {
      for (std::size_t c = 0; c < channels; ++c) ++own[c][*code++];
    }
    const std::lock_guard lock(adding);
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t k = 0; k < own[c].size(); ++k) histograms[c][k] += own[c][k];
    }
  };
  for_rows(static_cast<int>(frames.size()), add, frames_at_once);
  return histograms;
}

/// [channel] the shortest frame's codes where the longest is darkest: what little light falls there
/// is next to nothing in the shortest.
std::vector<DarkLevel> levels_of_darkest(const Image<std::uint16_t>& shortest,
                                         const Image<std::uint16_t>& longest, int saturated) {
  constexpr double darkest_share = 0.01;
  const auto channels = static_cast<std::size_t>(shortest.channels());
  std::vector<DarkLevel> levels;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<std::pair<int, int>> codes;  // in the longest, in the shortest frame
    for (std::size_t i = c; i < longest.size(); i += channels) {
      const int here = longest.values()[i];
      const int there = shortest.values()[i];
      if (here < saturated && there < saturated) codes.emplace_back(here, there);
    }
    if (codes.empty()) {
      levels.push_back({0.0, rounding});
      continue;
    }
    const auto darkest = static_cast<std::ptrdiff_t>(
        std::max(1.0, darkest_share * static_cast<double>(codes.size())));
    std::nth_element(codes.begin(), codes.begin() + darkest - 1, codes.end());
    std::vector<double> black;
    for (auto code = codes.begin(); code != codes.begin() + darkest; ++code) {
      black.push_back(code->second);
    }
    const double level = upper_median(black);
    for (double& code : black) code = std::abs(code - level);
    levels.push_back(
        {level, std::max(rounding, deviations_per_median_distance * upper_median(black))});
  }
  return levels;
}

/// Where the codes of two exposures meet at no exposure, one channel.
DarkLevel level_at_no_exposure(const Image<std::uint16_t>& shorter, double t1,
                               const Image<std::uint16_t>& longer, double t2, std::size_t channel,
                               int saturated) {
  struct Pixel {
    int longer, shorter;
  };
  std::vector<Pixel> pixels;
  const auto channels = static_cast<std::size_t>(shorter.channels());
  for (std::size_t i = channel; i < shorter.size(); i += channels) {
    const int z1 = shorter.values()[i], z2 = longer.values()[i];
    if (z1 < saturated && z2 < saturated) pixels.push_back({z2, z1});
  }
  if (pixels.empty()) return {};
  const std::size_t darkest = std::max<std::size_t>(pixels.size() / 10, 1);
  std::nth_element(
      pixels.begin(), pixels.begin() + static_cast<std::ptrdiff_t>(darkest - 1), pixels.end(),
      [](const Pixel& a, const Pixel& b) { return a.longer + a.shorter < b.longer + b.shorter; });
  std::vector<double> levels, distances;
  for (std::size_t i = 0; i < darkest; ++i) {
    levels.push_back((pixels[i].shorter * t2 - pixels[i].longer * t1) / (t2 - t1));
  }
  const double level = upper_median(levels);
  for (const double value : levels) distances.push_back(std::abs(value - level));
  const double deviation = deviations_per_median_distance * upper_median(distances);
  // Below zero beyond chance, the exposures contradict each other. Their spread is then no noise,
  // which would hide the contradiction from the check of frames.
  constexpr double certain = 5.0, of_a_median = 1.2533;
  const double standard_error = of_a_median * deviation / std::sqrt(static_cast<double>(darkest));
  if (level < -certain * standard_error) return {0.0, rounding};
  return {std::max(level, 0.0), deviation};
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
  std::vector<DarkLevel> levels;
  for (const auto& histogram : histograms_of(session, session.calibration.dark)) {
    levels.push_back(dark_level(histogram));
  }
  return levels;
}

std::vector<DarkLevel> dark_levels_of_stack(const Session& session, const Stack& stack) {
  constexpr double pedestal_share = 0.001;
  constexpr double wide_bracket = 100.0;
  const auto [shortest, longest] = std::minmax_element(
      stack.begin(), stack.end(),
      [](const Frame& a, const Frame& b) { return a.exposure_s < b.exposure_s; });
  std::vector<DarkLevel> levels;
  if (session.camera.encoding == Encoding::linear && shortest->exposure_s < longest->exposure_s) {
    const Image<std::uint16_t> shorter = load_sites(session, *shortest);
    const Image<std::uint16_t> longer = load_sites(session, *longest);
    const int top = session.camera.white_level.value_or(largest_code(session.camera));
    for (std::size_t c = 0; c < session.channels.size(); ++c) {
      levels.push_back(level_at_no_exposure(shorter, shortest->exposure_s, longer,
                                            longest->exposure_s, c, top * 9 / 10));
    }
    return levels;
  }
  if (longest->exposure_s >= wide_bracket * shortest->exposure_s) {
    return levels_of_darkest(load_sites(session, *shortest), load_sites(session, *longest),
                             saturation_code(session.camera.bit_depth));
  }
  for (const auto& histogram : histograms_of(session, {*shortest})) {
    levels.push_back({static_cast<double>(quantile(histogram, pedestal_share)), rounding});
  }
  return levels;
}

}  // namespace kappamu::capture
