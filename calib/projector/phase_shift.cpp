#include "calib/projector/phase_shift.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace kappamu::calib {
namespace {

constexpr double least_amplitude = 0.02;   // of the brightest pixel
constexpr double furthest_step = 3.0 / 8;  // of a period, from what the longer period says

struct Phase {
  Image<float> place;      ///< [y][x] u within one period [px]
  Image<float> amplitude;  ///< [y][x] b
  Image<float> mean;       ///< [y][x] a
};

Phase phase_of(const PhaseFrames& set) {
  const Image<float>& first = set.frames.front();
  Phase phase{Image<float>(first.width(), first.height(), 1),
              Image<float>(first.width(), first.height(), 1),
              Image<float>(first.width(), first.height(), 1)};
  const auto count = static_cast<double>(set.frames.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    double sine = 0.0, cosine = 0.0, sum = 0.0;
    for (std::size_t n = 0; n < set.frames.size(); ++n) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(n) / count;
      const double value = set.frames[n].values()[k];
      sine += value * std::sin(angle);
      cosine += value * std::cos(angle);
      sum += value;
    }
    const double turn = std::atan2(sine, cosine) / (2.0 * std::numbers::pi);
    phase.place.values()[k] = static_cast<float>((turn - std::floor(turn)) * set.period_px);
    phase.amplitude.values()[k] = static_cast<float>(2.0 / count * std::hypot(sine, cosine));
    phase.mean.values()[k] = static_cast<float>(sum / count);
  }
  return phase;
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
  check(!sets.empty() && !sets.front().frames.empty(), "decode_phase_shift wants frames");
  std::sort(sets.begin(), sets.end(),
            [](const PhaseFrames& a, const PhaseFrames& b) { return a.period_px > b.period_px; });
  const Image<float>& first = sets.front().frames.front();
  ProjectorMap map{Image<float>(first.width(), first.height(), 2),
                   Image<float>(first.width(), first.height(), 1)};
  std::vector<float> quality(first.size(), 1.0F);
  const std::array<int, 2> extent{projector.width, projector.height};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    bool longest = true;
    for (const PhaseFrames& set : sets) {
      if ((set.along == capture::PhaseShift::Along::columns) != (axis == 0)) continue;
      const Phase phase = phase_of(set);
      float brightest = 0.0F;
      for (std::size_t k = 0; k < first.size(); ++k) {
        brightest = std::max(brightest, phase.mean.values()[k] + phase.amplitude.values()[k]);
      }
      for (std::size_t k = 0; k < first.size(); ++k) {
        float& place = map.pixel.values()[2 * k + axis];
        const float amplitude = phase.amplitude.values()[k], mean = phase.mean.values()[k];
        quality[k] = std::min(quality[k], amplitude >= least_amplitude * brightest && mean > 0.0F
                                              ? amplitude / mean
                                              : 0.0F);
        std::optional<double> found = phase.place.values()[k];
        if (longest && coarse) {
          if (coarse->quality.values()[k] <= 0.0F) quality[k] = 0.0F;
          found = unwrapped(*found, set.period_px, coarse->pixel.values()[2 * k + axis]);
        } else if (!longest) {
          found = unwrapped(*found, set.period_px, place);
        }
        if (!found) quality[k] = 0.0F;
        place = static_cast<float>(found.value_or(0.0));
      }
      longest = false;
    }
    check(!longest, "decode_phase_shift wants a set along columns and one along rows");
    for (std::size_t k = 0; k < first.size(); ++k) {
      const float place = map.pixel.values()[2 * k + axis];
      if (!(place >= -0.5F && place <= static_cast<float>(extent[axis]) - 0.5F)) quality[k] = 0.0F;
    }
  }
  std::copy(quality.begin(), quality.end(), map.quality.values().begin());
  return map;
}

}  // namespace kappamu::calib
