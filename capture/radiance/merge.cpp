#include "capture/radiance/merge.h"

#include <algorithm>
#include <cmath>

#include "capture/response/frame_reader.h"
#include "capture/response/noise_model.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/shown_text.h"

namespace kappamu::capture {
namespace {

// A frame is left out where the merged estimate puts it within this many standard deviations of
// saturation: a pixel kept only when its noise happens to be low would be biased.
constexpr float saturation_margin_sigmas = 4.0F;

struct Sum {
  float radiance = 0.0F;
  float variance = 0.0F;
  std::uint8_t flags = pixel_ok;
};

// Merges one pixel's values; `value(j)` is that of frame j, frames by rising exposure time.
template <class Reader>
class PixelMerger {
 public:
  PixelMerger(Reader reader, const NoiseModel& noise, const std::vector<float>& exposures)
      : reader_(std::move(reader)), noise_(noise), exposures_(exposures) {
    while (repeats_ < exposures_.size() && exposures_[repeats_] == exposures_.front()) ++repeats_;
    limit_ = reader_.saturation() -
             saturation_margin_sigmas * std::sqrt(noise_.variance(reader_.saturation()));
    dark_deviation_ = std::sqrt(noise_.variance(0.0F));
  }

  template <class Value>
  Sum merge(const Value& value) const {
    // First every frame weighted by its time, which leans least on the longest one and so decides
    // fairly which frames are near saturation.
    float signal = 0.0F;
    float time = 0.0F;
    std::size_t usable = 0;
    for (; usable < exposures_.size() && !reader_.saturated(value(usable)); ++usable) {
      signal += reader_.linear(value(usable));
      time += exposures_[usable];
    }                         // longer ones than the first saturated are saturated too, or moved
    if (usable < repeats_) {  // of those that noise happens to keep below, the mean would be biased
      const float bound = reader_.saturation() / exposures_.front();
      return {bound, bound * bound, pixel_saturated};
    }
    while (usable > repeats_ && signal / time * exposures_[usable - 1] > limit_) --usable;
    // Then by time squared, best under read noise, where the weights need a good estimate most.
    float moment = 0.0F;
    float squares = 0.0F;
    for (std::size_t j = 0; j < usable; ++j) {
      moment += exposures_[j] * reader_.linear(value(j));
      squares += exposures_[j] * exposures_[j];
    }
    const float first = moment / squares;
    const float longest = exposures_[usable - 1];
    Sum sum = by_variance(value, usable, first);
    if (sum.radiance * longest < dark_deviation_) sum.flags = pixel_dark;
    return sum;
  }

 private:
  template <class Value>
  Sum by_variance(const Value& value, std::size_t usable, float first) const {
    float weighted = 0.0F;
    float weights = 0.0F;
    for (std::size_t j = 0; j < usable; ++j) {
      const float t = exposures_[j];
      // Radiance is linear(value)/t, of variance noise/t².
      const float weight = t / noise_.variance(first * t);
      weighted += weight * reader_.linear(value(j));
      weights += weight * t;
    }
    return {weighted / weights, 1.0F / weights};
  }

  Reader reader_;
  const NoiseModel& noise_;
  const std::vector<float>& exposures_;
  std::size_t repeats_ = 0;  // of the shortest exposure
  float limit_ = 0.0F;
  float dark_deviation_ = 0.0F;
};

void check_light(const HdrImage& image, const std::vector<float>& exposures,
                 const std::string& name, bool require_light) {
  const auto all = [&](std::uint8_t flag) {
    return std::all_of(image.flags.values().begin(), image.flags.values().end(),
                       [flag](std::uint8_t value) { return (value & flag) != 0; });
  };
  const std::string frames = "in all " + std::to_string(exposures.size()) + " frames";
  if (all(pixel_saturated)) {
    throw InputError(name + ": every pixel is saturated " + frames +
                     "; add exposures shorter than " + shown_number(exposures.front(), "%.4g s") +
                     ".");
  }
  if (require_light && all(pixel_dark)) {
    throw InputError(name + ": every pixel is darker than the noise " + frames +
                     "; add exposures longer than " + shown_number(exposures.back(), "%.4g s") +
                     " or check that the projector was on.");
  }
}

template <class Value>
HdrImage merge(std::span<const Exposed<Value>> frames, const Radiometry& radiometry,
               const std::string& name, const MergeOptions& options) {
  using Reader = FrameReader<Value>;
  if (frames.empty()) throw InputError(name + ": there are no frames to merge; add at least one.");
  std::vector<const Exposed<Value>*> sorted;
  for (const Exposed<Value>& frame : frames) sorted.push_back(&frame);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto* a, const auto* b) { return a->exposure_s < b->exposure_s; });
  const Image<Value>& shape = sorted.front()->pixels;
  const int channels = shape.channels();
  std::vector<const Value*> pixels;  // of frame j, by rising exposure time
  std::vector<float> exposures;
  for (const Exposed<Value>* frame : sorted) {
    check(frame->pixels.same_shape(shape), "merge: frames of one stack differ in shape");
    pixels.push_back(frame->pixels.values().data());
    exposures.push_back(static_cast<float>(frame->exposure_s));
  }
  check(radiometry.response.linear.size() == static_cast<std::size_t>(channels) &&
            radiometry.noise.size() == static_cast<std::size_t>(channels),
        "merge: radiometry and frames differ in channels");
  HdrImage out{Image<float>(shape.width(), shape.height(), channels),
               Image<float>(shape.width(), shape.height(), channels),
               Image<std::uint8_t>(shape.width(), shape.height(), channels)};
  std::vector<NoiseModel> noises;
  std::vector<PixelMerger<Reader>> mergers;  // by channel
  for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
    noises.emplace_back(radiometry.response.linear[c], radiometry.noise[c], Reader::rounding);
  }
  for (int c = 0; c < channels; ++c) {
    mergers.emplace_back(Reader(radiometry, c), noises[static_cast<std::size_t>(c)], exposures);
  }
  const std::size_t row =
      static_cast<std::size_t>(shape.width()) * static_cast<std::size_t>(channels);
  for_rows(shape.height(), [&](int y) {
    const std::size_t begin = static_cast<std::size_t>(y) * row;
    for (std::size_t c = 0; c < mergers.size(); ++c) {
      for (std::size_t i = begin + c; i < begin + row; i += mergers.size()) {
        const Sum sum = mergers[c].merge([&](std::size_t j) { return pixels[j][i]; });
        out.radiance.values()[i] = sum.radiance;
        out.variance.values()[i] = sum.variance;
        out.flags.values()[i] = sum.flags;
      }
    }
  });
  check_light(out, exposures, name, options.require_light);
  return out;
}

}  // namespace

HdrImage merge_frames(std::span<const ExposedFrame> frames, const Radiometry& radiometry,
                      const std::string& name, const MergeOptions& options) {
  return merge(frames, radiometry, name, options);
}

HdrImage merge_frames(std::span<const ExposedFloatFrame> frames, const Radiometry& radiometry,
                      const std::string& name, const MergeOptions& options) {
  return merge(frames, radiometry, name, options);
}

}  // namespace kappamu::capture
