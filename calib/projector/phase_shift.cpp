#include "calib/projector/phase_shift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::calib {
namespace {

constexpr double least_amplitude = 0.02;   // of the brightest pixel
constexpr double furthest_step = 3.0 / 8;  // of a period, from what the longer period says

/// [y][x] sums over the frames of one period.
struct PhaseSums {
  double count = 0.0, period_px = 0.0;
  Image<float> sine, cosine, sum;

  float place(std::size_t k) const {  ///< u within one period [px]
    const double turn = std::atan2(sine.values()[k], cosine.values()[k]) / (2.0 * std::numbers::pi);
    return static_cast<float>((turn - std::floor(turn)) * period_px);
  }
  float amplitude(std::size_t k) const {  ///< b
    return static_cast<float>(2.0 / count * std::hypot(sine.values()[k], cosine.values()[k]));
  }
  float mean(std::size_t k) const {  ///< a
    return static_cast<float>(sum.values()[k] / count);
  }
};

PhaseSums sums_of(const PhaseFrames& set) {
  PhaseSums sums{static_cast<double>(set.count), set.period_px, {}, {}, {}};
  for (std::size_t n = 0; n < set.count; n += 2) {
    const std::size_t held = std::min<std::size_t>(2, set.count - n);
    std::array<Image<float>, 2> frames;
    for_rows(static_cast<int>(held), [&](int i) {
      frames[static_cast<std::size_t>(i)] = set.frames(n + static_cast<std::size_t>(i));
    });
    const Image<float>& first = frames.front();
    if (n == 0) sums.sine = sums.cosine = sums.sum = Image<float>(first.width(), first.height(), 1);
    for (std::size_t i = 0; i < held; ++i) {
      check(frames[i].same_shape(sums.sum), "the frames of a phase shift are of one size");
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(n + i) / sums.count;
      const auto by_sine = static_cast<float>(std::sin(angle));
      const auto by_cosine = static_cast<float>(std::cos(angle));
      for_ranges(first.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const float value = frames[i].values()[k];
          sums.sine.values()[k] += value * by_sine;
          sums.cosine.values()[k] += value * by_cosine;
          sums.sum.values()[k] += value;
        }
      });
    }
  }
  return sums;
}

/// Where `place` of a period lies nearest to `known`; nothing where the next period is as near.
std::optional<double> unwrapped(double place, double period_px, double known) {
  const double whole = std::round((known - place) / period_px);
  const double found = place + whole * period_px;
  if (std::abs(found - known) > furthest_step * period_px) return std::nullopt;
  return found;
}

}  // namespace

ProjectorMap decode_phase_shift(std::vector<PhaseFrames> sets, const capture::Projector& projector,
                                const std::optional<ProjectorMap>& coarse) {
  check(!sets.empty() && sets.front().count > 0, "decode_phase_shift wants frames");
  std::sort(sets.begin(), sets.end(),
            [](const PhaseFrames& a, const PhaseFrames& b) { return a.period_px > b.period_px; });
  ProjectorMap map;
  const std::array<int, 2> extent{projector.width, projector.height};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    bool longest = true;
    for (const PhaseFrames& set : sets) {
      if ((set.along == capture::PhaseShift::Along::columns) != (axis == 0)) continue;
      const PhaseSums phase = sums_of(set);
      const std::size_t size = phase.sum.size();
      if (map.quality.empty()) {
        map.pixel = Image<float>(phase.sum.width(), phase.sum.height(), 2);
        map.quality = Image<float>(phase.sum.width(), phase.sum.height(), 1, 1.0F);
      }
      check(map.quality.same_shape(phase.sum), "the frames of a phase shift are of one size");
      float brightest = 0.0F;
      for (std::size_t k = 0; k < size; ++k) {
        brightest = std::max(brightest, phase.mean(k) + phase.amplitude(k));
      }
      for_ranges(size, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          float& place = map.pixel.values()[2 * k + axis];
          float& quality = map.quality.values()[k];
          const float amplitude = phase.amplitude(k), mean = phase.mean(k);
          quality = std::min(quality, amplitude >= least_amplitude * brightest && mean > 0.0F
                                          ? amplitude / mean
                                          : 0.0F);
          std::optional<double> found = phase.place(k);
          if (longest && coarse) {
            if (coarse->quality.values()[k] <= 0.0F) quality = 0.0F;
            found = unwrapped(*found, set.period_px, coarse->pixel.values()[2 * k + axis]);
          } else if (!longest) {
            found = unwrapped(*found, set.period_px, place);
          }
          if (!found) quality = 0.0F;
          place = static_cast<float>(found.value_or(0.0));
        }
      });
      longest = false;
    }
    check(!longest, "decode_phase_shift wants a set along columns and one along rows");
    for (std::size_t k = 0; k < map.quality.size(); ++k) {
      const float place = map.pixel.values()[2 * k + axis];
      if (!(place >= -0.5F && place <= static_cast<float>(extent[axis]) - 0.5F)) {
        map.quality.values()[k] = 0.0F;
      }
    }
  }
  return map;
}

}  // namespace kappamu::calib
