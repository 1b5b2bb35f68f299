#include "capture/radiance/merge.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/response/frame_reader.h"
#include "capture/response/noise_model.h"
#include "core/error.h"
#include "core/numbers/widest.h"
#include "core/parallel.h"
#include "core/shown_text.h"

namespace kappamu::capture {
namespace {

// A frame is left out where the merged estimate puts it within this many standard deviations of
// saturation: a pixel kept only when its noise happens to be low would be biased.
constexpr float saturation_margin_sigmas = 4.0F;

/// Pixels of one row that are merged together, so that loops over them fill wide registers.
constexpr std::size_t block = NoiseModel::most_at_once;
using Block = std::array<float, block>;
using Counts = std::array<std::int32_t, block>;

/// What the values of one channel have in common; frames by rising exposure time.
struct Weighing {
  NoiseModel noise;
  std::vector<float> exposures;                                  ///< [s]
  std::int32_t repeats = 0;                                      ///< of the shortest exposure
  float saturation = 0.0F, limit = 0.0F, dark_deviation = 0.0F;  ///< linear signal
};

/// One channel of a block.
struct Values {
  std::vector<float> linear;  ///< [frame][pixel] signal above black
  Counts usable{};            ///< frames before the first saturated one: longer ones are, too
  Block radiance{}, variance{};
  Counts flags{};
};

KAPPAMU_WIDEST void weigh(const Weighing& of, std::size_t count, Values& values) {
  const auto frames = static_cast<std::int32_t>(of.exposures.size());
  const float* const linear = values.linear.data();
  // First every frame weighted by its time, which leans least on the longest one and so decides
  // fairly which frames are near saturation.
  Block mean{}, sum{};
  for (std::int32_t j = 0; j < frames; ++j) {
    const float t = of.exposures[static_cast<std::size_t>(j)];
    const float* x = linear + static_cast<std::size_t>(j) * block;
    for (std::size_t i = 0; i < count; ++i) {
      const bool counts = j < values.usable[i];
      mean[i] += counts ? x[i] : 0.0F;
      sum[i] += counts ? t : 0.0F;
    }
  }
  for (std::size_t i = 0; i < count; ++i) mean[i] /= sum[i];
  // Then by time squared, best under read noise, where the weights need a good estimate most.
  Block first{}, squares{}, longest{};
  Counts kept{};
  for (std::int32_t j = 0; j < frames; ++j) {
    const float t = of.exposures[static_cast<std::size_t>(j)];
    const float* x = linear + static_cast<std::size_t>(j) * block;
    const float most = j < of.repeats ? HUGE_VALF : of.limit;
    for (std::size_t i = 0; i < count; ++i) {
      const bool counts = (j < values.usable[i]) & !(mean[i] * t > most);
      first[i] += counts ? t * x[i] : 0.0F;
      squares[i] += counts ? t * t : 0.0F;
      longest[i] = counts ? t : longest[i];
      kept[i] += counts ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < count; ++i) first[i] /= squares[i];
  Block weighted{}, weights{}, noise{};
  for (std::int32_t j = 0; j < frames; ++j) {
    const float t = of.exposures[static_cast<std::size_t>(j)];
    const float* x = linear + static_cast<std::size_t>(j) * block;
    of.noise.variances(first.data(), t, count, noise.data());
    for (std::size_t i = 0; i < count; ++i) {
      const float by_noise = t / noise[i];  // radiance is linear/t, of variance noise/t²
      const float weight = j < kept[i] ? by_noise : 0.0F;
      weighted[i] += weight * x[i];
      weights[i] += weight * t;
    }
  }
  // Of those shortest frames that noise happens to keep below saturation, the mean would be biased.
  const float bound = of.saturation / of.exposures.front();
  for (std::size_t i = 0; i < count; ++i) {
    const bool saturated = values.usable[i] < of.repeats;
    const float radiance = weighted[i] / weights[i], variance = 1.0F / weights[i];
    const bool dark = radiance * longest[i] < of.dark_deviation;
    values.radiance[i] = saturated ? bound : radiance;
    values.variance[i] = saturated ? bound * bound : variance;
    values.flags[i] =
        (saturated ? pixel_saturated : pixel_ok) | (dark && !saturated ? pixel_dark : pixel_ok);
  }
}

template <class Reader>
Weighing weighing(const Reader& reader, NoiseModel noise, const std::vector<float>& exposures) {
  Weighing of{std::move(noise), exposures};
  of.repeats =
      static_cast<std::int32_t>(std::count(exposures.begin(), exposures.end(), exposures.front()));
  of.saturation = reader.saturation();
  of.limit = of.saturation - saturation_margin_sigmas * std::sqrt(of.noise.variance(of.saturation));
  of.dark_deviation = std::sqrt(of.noise.variance(0.0F));
  return of;
}

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

/// `count` values of one channel, the first at `begin`, `step` apart, of all frames.
template <class Value>
void read_block(const FrameReader<Value>& reader, const std::vector<const Value*>& frames,
                std::size_t begin, std::size_t step, std::size_t count, Values& values) {
  values.usable.fill(0);
  for (std::size_t j = 0; j < frames.size(); ++j) {
    const Value* from = frames[j] + begin;
    float* to = &values.linear[j * block];
    for (std::size_t i = 0; i < count; ++i) {
      const Value value = from[i * step];
      to[i] = reader.linear(value);
      const bool counts =
          values.usable[i] == static_cast<std::int32_t>(j) && !reader.saturated(value);
      values.usable[i] += counts ? 1 : 0;
    }
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
  std::vector<Reader> readers;  // by channel
  std::vector<Weighing> weighings;
  for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
    readers.emplace_back(radiometry, static_cast<int>(c));
    weighings.push_back(
        weighing(readers.back(),
                 NoiseModel(radiometry.response.linear[c], radiometry.noise[c], Reader::rounding),
                 exposures));
  }
  const auto width = static_cast<std::size_t>(shape.width());
  for_rows(shape.height(), [&](int y) {
    Values values;
    values.linear.resize(pixels.size() * block);
    for (std::size_t x = 0; x < width; x += block) {
      const std::size_t count = std::min(block, width - x);
      const std::size_t begin = (static_cast<std::size_t>(y) * width + x) * readers.size();
      for (std::size_t c = 0; c < readers.size(); ++c) {
        read_block(readers[c], pixels, begin + c, readers.size(), count, values);
        weigh(weighings[c], count, values);
        for (std::size_t i = 0, at = begin + c; i < count; ++i, at += readers.size()) {
          out.radiance.values()[at] = values.radiance[i];
          out.variance.values()[at] = values.variance[i];
          out.flags.values()[at] = static_cast<std::uint8_t>(values.flags[i]);
        }
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
