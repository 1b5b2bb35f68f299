#include "capture/radiance/merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <type_traits>

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

/// Values that are merged together, of all channels in turn, so that loops over them fill wide
/// registers: whole pixels of 1, 3 or 4 channels.
constexpr std::size_t block = 192;
using Block = std::array<float, block>;
using Counts = std::array<std::int32_t, block>;

/// What merging needs of each channel, for every value of a block by its own; frames by rising
/// exposure time.
struct Weighing {
  std::vector<float> exposures;  ///< [s]
  std::int32_t repeats = 0;      ///< of the shortest exposure
  std::size_t length = block;    ///< of a block: a multiple of the channels

  /// Signal (value − black) · scale, its variance still + shot · signal and least_noise at least. A
  /// camera with a curve takes both from tables instead, by channel.
  bool straight = true;
  Block black{}, scale{}, still{}, shot{}, least_noise{};
  std::vector<std::vector<float>> signals{}, noise{};

  Block saturated_from{};  ///< stored value
  Block limit{}, dark_deviation{}, bound{};
};

/// A block of a picture's values.
struct Merged {
  float *radiance, *variance;
  std::uint8_t* flags;
};

/// Entries of the tables of a block's channels. Value by value: instructions that look up several
/// at once take longer.
template <class Index>
void look_up(const std::vector<std::vector<float>>& tables, const Index* entries, std::size_t count,
             float* found) {
  constexpr std::size_t colours = 3;
  if (tables.size() == colours) {
    const float *const red = tables[0].data(), *const green = tables[1].data(),
                       *const blue = tables[2].data();
    for (std::size_t i = 0; i + 2 < count; i += colours) {
      found[i] = red[entries[i]];
      found[i + 1] = green[entries[i + 1]];
      found[i + 2] = blue[entries[i + 2]];
    }
    return;
  }
  for (std::size_t c = 0; c < tables.size(); ++c) {
    const float* const table = tables[c].data();
    for (std::size_t i = c; i < count; i += tables.size()) found[i] = table[entries[i]];
  }
}

template <bool straight>
[[gnu::always_inline]] inline void find_noise(const Weighing& of, const Block& radiance, float t,
                                              std::size_t count, Block& noise) {
  if constexpr (straight) {
    for (std::size_t i = 0; i < count; ++i) {
      const float signal = t * radiance[i];
      const float sum = of.still[i] + of.shot[i] * (signal < 1.0F ? signal : 1.0F);
      noise[i] = sum > of.least_noise[i] ? sum : of.least_noise[i];
    }
    return;
  }
  constexpr std::int32_t last = NoiseModel::entries - 1;
  Counts at;
  for (std::size_t i = 0; i < count; ++i) {
    const float signal = t * radiance[i];
    const float root = std::sqrt(signal > 0.0F ? signal : 0.0F);  // 0 for not a number
    at[i] = static_cast<std::int32_t>(0.5F + (root < 1.0F ? root : 1.0F) * last);
  }
  look_up(of.noise, at.data(), count, noise.data());
  for (std::size_t i = 0; i < count; ++i) {
    const float signal = t * radiance[i];
    const float sum = noise[i] + (signal < 0.0F ? signal : 0.0F) * of.shot[i];
    noise[i] = sum > of.least_noise[i] ? sum : of.least_noise[i];
  }
}

/// Values [begin, begin + count) of all frames.
template <bool straight, class Value>
[[gnu::always_inline]] inline void merge_block(const Weighing& of,
                                               const std::vector<const Value*>& from,
                                               std::size_t begin, std::size_t count, float* linear,
                                               const Merged& out) {
  const auto frames = static_cast<std::int32_t>(from.size());
  Counts usable{};  // frames before the first saturated one: longer ones are, too
  // First every frame weighted by its time, which leans least on the longest one and so decides
  // fairly which frames are near saturation.
  Block mean{}, sum{};
  std::int32_t seen = 0;  // frames that are usable somewhere in the block
  for (std::int32_t j = 0; j < frames; ++j) {
    const Value* values = from[static_cast<std::size_t>(j)] + begin;
    for (std::size_t i = 0; i < count; ++i) {
      const bool counts = (usable[i] == j) & (static_cast<float>(values[i]) < of.saturated_from[i]);
      usable[i] += counts ? 1 : 0;
      seen = usable[i] > seen ? usable[i] : seen;
    }
    if (seen == j) break;
    float* x = linear + static_cast<std::size_t>(j) * block;
    const float t = of.exposures[static_cast<std::size_t>(j)];
    if constexpr (straight) {
      for (std::size_t i = 0; i < count; ++i)
        x[i] = (static_cast<float>(values[i]) - of.black[i]) * of.scale[i];
    } else {
      look_up(of.signals, values, count, x);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const bool counts = usable[i] > j;
      mean[i] += counts ? x[i] : 0.0F;
      sum[i] += counts ? t : 0.0F;
    }
  }
  for (std::size_t i = 0; i < count; ++i) mean[i] /= sum[i];
  // Then by time squared, best under read noise, where the weights need a good estimate most.
  Block first{}, squares{}, longest{};
  Counts kept{};
  std::int32_t weighed = 0;  // frames that are kept somewhere in the block
  for (std::int32_t j = 0; j < seen; ++j) {
    const float t = of.exposures[static_cast<std::size_t>(j)];
    const float* x = linear + static_cast<std::size_t>(j) * block;
    const bool shortest = j < of.repeats;
    for (std::size_t i = 0; i < count; ++i) {
      const bool counts = (j < usable[i]) & (shortest | !(mean[i] * t > of.limit[i]));
      first[i] += counts ? t * x[i] : 0.0F;
      squares[i] += counts ? t * t : 0.0F;
      longest[i] = counts ? t : longest[i];
      kept[i] += counts ? 1 : 0;
      weighed = kept[i] > weighed ? kept[i] : weighed;
    }
  }
  for (std::size_t i = 0; i < count; ++i) first[i] /= squares[i];
  Block weighted{}, weights{}, noise;
  for (std::int32_t j = 0; j < weighed; ++j) {
    const float t = of.exposures[static_cast<std::size_t>(j)];
    const float* x = linear + static_cast<std::size_t>(j) * block;
    find_noise<straight>(of, first, t, count, noise);
    for (std::size_t i = 0; i < count; ++i) {
      const float by_noise = t / noise[i];  // radiance is linear/t, of variance noise/t²
      const float weight = j < kept[i] ? by_noise : 0.0F;
      weighted[i] += weight * x[i];
      weights[i] += weight * t;
    }
  }
  // Of those shortest frames that noise happens to keep below saturation, the mean would be biased.
  Block radiances, variances;
  Counts flags;
  for (std::size_t i = 0; i < count; ++i) {
    const float radiance = weighted[i] / weights[i], variance = 1.0F / weights[i];
    const bool saturated = usable[i] < of.repeats;
    flags[i] = radiance * longest[i] < of.dark_deviation[i] ? pixel_dark : pixel_ok;
    flags[i] = saturated ? pixel_saturated : flags[i];
    radiances[i] = saturated ? of.bound[i] : radiance;
    variances[i] = saturated ? of.bound[i] * of.bound[i] : variance;
  }
  std::copy_n(radiances.data(), count, out.radiance);
  std::copy_n(variances.data(), count, out.variance);
  std::copy_n(flags.data(), count, out.flags);
}

KAPPAMU_WIDEST void merge_codes(const Weighing& of, const std::vector<const std::uint16_t*>& from,
                                std::size_t begin, std::size_t count, float* linear,
                                const Merged& out) {
  merge_block<true>(of, from, begin, count, linear, out);
}
KAPPAMU_WIDEST void merge_curved_codes(const Weighing& of,
                                       const std::vector<const std::uint16_t*>& from,
                                       std::size_t begin, std::size_t count, float* linear,
                                       const Merged& out) {
  merge_block<false>(of, from, begin, count, linear, out);
}
KAPPAMU_WIDEST void merge_floats(const Weighing& of, const std::vector<const float*>& from,
                                 std::size_t begin, std::size_t count, float* linear,
                                 const Merged& out) {
  merge_block<true>(of, from, begin, count, linear, out);
}

template <class Value>
Weighing weighing(const Radiometry& radiometry, std::size_t channels,
                  std::vector<float> exposures) {
  using Reader = FrameReader<Value>;
  Weighing of;
  of.length = block / channels * channels;
  of.repeats =
      static_cast<std::int32_t>(std::count(exposures.begin(), exposures.end(), exposures.front()));
  for (std::size_t c = 0; c < channels; ++c) {
    const Reader reader(radiometry, static_cast<int>(c));
    const NoiseModel noise(radiometry.response.linear[c], radiometry.noise[c], Reader::rounding);
    const std::optional<Line> line = reader.line();
    of.straight = of.straight && line && noise.straight();
    const float saturation = reader.saturation();
    const float deviation = std::sqrt(noise.variance(saturation));
    for (std::size_t i = c; i < of.length; i += channels) {
      of.black[i] = line.value_or(Line{}).zero;
      of.scale[i] = line.value_or(Line{}).scale;
      of.still[i] = noise.variance(0.0F);
      of.shot[i] = noise.shot_per_signal();
      of.least_noise[i] = noise.least();
      of.saturated_from[i] = static_cast<float>(reader.saturated_from());
      of.limit[i] = saturation - saturation_margin_sigmas * deviation;
      of.dark_deviation[i] = std::sqrt(noise.variance(0.0F));
      of.bound[i] = saturation / exposures.front();
    }
    of.signals.emplace_back(reader.table().begin(), reader.table().end());
    of.noise.push_back(noise.table());
  }
  of.exposures = std::move(exposures);
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

template <class Value>
HdrImage merge(std::span<const Exposed<Value>> frames, const Radiometry& radiometry,
               const std::string& name, const MergeOptions& options) {
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
  const Weighing of = weighing<Value>(radiometry, static_cast<std::size_t>(channels), exposures);
  for_pieces(out.flags.size(), 256 * of.length, [&](std::size_t, std::size_t at, std::size_t end) {
    std::vector<float> linear(pixels.size() * block);
    for (; at < end; at += of.length) {
      const std::size_t count = std::min(of.length, end - at);
      const Merged to{&out.radiance.values()[at], &out.variance.values()[at],
                      &out.flags.values()[at]};
      if constexpr (std::is_same_v<Value, float>) {
        merge_floats(of, pixels, at, count, linear.data(), to);
      } else if (of.straight) {
        merge_codes(of, pixels, at, count, linear.data(), to);
      } else {
        merge_curved_codes(of, pixels, at, count, linear.data(), to);
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
