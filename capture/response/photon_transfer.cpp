#include "capture/response/photon_transfer.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/median.h"

namespace kappamu::capture {
namespace {

constexpr int signal_bins = 24;
constexpr std::size_t least_pixels_per_bin = 200;
constexpr std::size_t pixels_per_frame = 400000;  // more add nothing
constexpr double normal_quartile = 0.6745;

double rounding_variance(const std::vector<double>& response, std::uint16_t code) {
  const std::size_t low = code > 0 ? code - 1U : 0U;
  const std::size_t high = std::min<std::size_t>(code + 1U, response.size() - 1);
  const double slope = (response[high] - response[low]) / static_cast<double>(high - low);
  return slope * slope / 12.0;
}

// Differences of one pair of frames in one bin of the expected signal in the shorter frame.
struct Bin {
  std::vector<double> differences;
  double signal = 0.0;
  double rounding = 0.0;
};

}  // namespace

std::optional<double> electrons_at_full_scale(std::span<const ExposedFrame> stack, int channel,
                                              const std::vector<double>& response,
                                              double read_deviation) {
  std::vector<const ExposedFrame*> sorted;
  for (const ExposedFrame& frame : stack) sorted.push_back(&frame);
  std::sort(sorted.begin(), sorted.end(), [](const ExposedFrame* a, const ExposedFrame* b) {
    return a->exposure_s < b->exposure_s;
  });
  const int saturated = saturation_code(response);
  std::vector<double> estimates;  // of 1/N
  for (std::size_t pair = 0; pair + 1 < sorted.size(); ++pair) {
    const std::vector<std::uint16_t>& shorter = sorted[pair]->pixels.values();
    const std::vector<std::uint16_t>& longer = sorted[pair + 1]->pixels.values();
    const double ratio = sorted[pair]->exposure_s / sorted[pair + 1]->exposure_s;
    const auto channels = static_cast<std::size_t>(sorted[pair]->pixels.channels());
    const std::size_t stride =
        channels * std::max<std::size_t>(1, shorter.size() / channels / pixels_per_frame);
    std::vector<Bin> bins(signal_bins);
    for (std::size_t i = static_cast<std::size_t>(channel); i < shorter.size(); i += stride) {
      if (longer[i] >= saturated || shorter[i] >= saturated) continue;
      // Sorted by the longer frame alone, so that the shorter one's noise does not choose its bin.
      const double signal = ratio * response[longer[i]];
      if (signal <= 0.0) continue;
      const auto at = static_cast<std::size_t>(std::sqrt(signal / ratio) * signal_bins);
      Bin& bin = bins[std::min<std::size_t>(at, signal_bins - 1)];
      bin.differences.push_back(response[shorter[i]] - signal);
      bin.signal += signal;
      bin.rounding += rounding_variance(response, shorter[i]) +
                      ratio * ratio * rounding_variance(response, longer[i]);
    }
    for (Bin& bin : bins) {
      if (bin.differences.size() < least_pixels_per_bin) continue;
      const auto count = static_cast<double>(bin.differences.size());
      const double middle = upper_median(bin.differences);  // what the response curve gets wrong
      for (double& difference : bin.differences) difference = std::abs(difference - middle);
      const double spread = upper_median(bin.differences) / normal_quartile;
      const double known =
          bin.rounding / count + read_deviation * read_deviation * (1.0 + ratio * ratio);
      const double shot = spread * spread - known;
      // Bins where read noise and rounding rule tell nothing about N.
      if (shot < known) continue;
      estimates.push_back(shot / (bin.signal / count * (1.0 + ratio)));
    }
  }
  if (estimates.empty()) return std::nullopt;
  return 1.0 / upper_median(estimates);
}

}  // namespace kappamu::capture
