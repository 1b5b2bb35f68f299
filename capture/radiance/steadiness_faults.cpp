// What the states of a stack's frames mean, in words. Declared in steadiness.h.
#include <algorithm>
#include <cmath>

#include "capture/radiance/steadiness.h"
#include "core/shown_text.h"

namespace kappamu::capture {
namespace {

constexpr double certain = 5.0;  // standard deviations
// A gain beyond this is no lamp's: the exposure time is wrong.
constexpr double mislabelled_gain = 0.15;
constexpr double unremarkable = 0.05;
// A drift is reported where a straight line in the order of the frames leaves this share of the
// variance.
constexpr double drift_residual_share = 0.1;
constexpr std::size_t least_drift_frames = 4;

std::string percent(double log_gain) {
  return shown_number(100.0 * std::abs(std::expm1(log_gain)), "%.1f %%");
}

std::string seconds(double value) {
  return shown_number(value, "%.4g s");
}

const char* brighter(double log_gain) {
  return log_gain > 0.0 ? "brighter" : "darker";
}

bool beyond(double value, double sigma, double tolerance) {
  return std::abs(value) > tolerance && std::abs(value) > certain * sigma;
}

std::vector<std::size_t> known_frames(const Steadiness& steadiness) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < steadiness.size(); ++i) {
    if (steadiness[i] && !steadiness[i]->blank) known.push_back(i);
  }
  return known;
}

// ln of the light at the last frame over that at the first, if a straight line in the frames'
// order explains the gains.
std::optional<double> drift_of(const Steadiness& steadiness,
                               const std::vector<std::size_t>& known) {
  if (known.size() < least_drift_frames) return std::nullopt;
  const auto count = static_cast<double>(known.size());
  double mean_at = 0.0;
  double mean_gain = 0.0;
  for (const std::size_t i : known) {
    mean_at += static_cast<double>(i) / count;
    mean_gain += steadiness[i]->log_gain / count;
  }
  double at_at = 0.0;
  double at_gain = 0.0;
  double gain_gain = 0.0;
  for (const std::size_t i : known) {
    const double at = static_cast<double>(i) - mean_at;
    const double gain = steadiness[i]->log_gain - mean_gain;
    at_at += at * at;
    at_gain += at * gain;
    gain_gain += gain * gain;
  }
  const double explained = at_gain * at_gain / at_at;
  if (gain_gain - explained > drift_residual_share * gain_gain) return std::nullopt;
  return at_gain / at_at * static_cast<double>(known.back() - known.front());
}

std::string which(const std::vector<std::size_t>& known, const std::string& others) {
  return known.size() > 2 ? others : "the other frame, one of the two being wrong";
}

std::optional<Fault> light_fault(const FrameState& state, std::size_t frame, double exposure_s,
                                 const std::vector<std::size_t>& known,
                                 const SteadyTolerance& tolerance) {
  if (!beyond(state.log_gain, state.log_gain_sigma, tolerance.gain)) return std::nullopt;
  const std::string error = " (standard deviation " + percent(state.log_gain_sigma) + ")";
  if (std::abs(state.log_gain) > mislabelled_gain) {
    return Fault{Fault::Kind::mislabelled, frame,
                 "its light fits an exposure time of " +
                     seconds(exposure_s * std::exp(state.log_gain)) + error + ", not the " +
                     seconds(exposure_s) + " stated, against " +
                     which(known, "the other frames of its stack")};
  }
  return Fault{Fault::Kind::flicker, frame,
               "its light is " + percent(state.log_gain) + " " + brighter(state.log_gain) +
                   " per second of exposure than that of " +
                   which(known, "the other frames of its stack") + error};
}

std::optional<Fault> motion_fault(const FrameState& state, std::size_t frame,
                                  const std::vector<std::size_t>& known,
                                  const SteadyTolerance& tolerance) {
  const double shift = std::hypot(state.shift_px[0], state.shift_px[1]);
  if (beyond(shift, state.shift_sigma_px, tolerance.shift_px)) {
    return Fault{
        Fault::Kind::moved, frame,
        "its picture is shifted by " + shown_number(shift, "%.2f") + " px (" +
            shown_number(state.shift_px[0], "%+.2f, ") + shown_number(state.shift_px[1], "%+.2f") +
            "; standard deviation " + shown_number(state.shift_sigma_px, "%.2g") + " px) against " +
            which(known, "the other frames of its stack") + ": sample, camera or projector moved"};
  }
  if (state.changed_share > tolerance.changed_share) {
    return Fault{Fault::Kind::changed, frame,
                 shown_number(100.0 * state.changed_share, "%.0f %%") +
                     " of its picture differ from " +
                     which(known, "the other frames of its stack") +
                     " by more than light or a shift explain: something moved in front of it"};
  }
  return std::nullopt;
}

}  // namespace

SteadyTolerance tolerance_for(const Radiometry& radiometry) {
  SteadyTolerance tolerance;
  for (const ResponseReport& report : radiometry.reports) {
    tolerance.gain = std::max({tolerance.gain, 0.015, 3.0 * report.residual_rms});
  }
  return tolerance;
}

std::vector<Fault> find_faults(const Steadiness& steadiness, std::span<const double> exposures_s,
                               std::span<const std::string> files,
                               const SteadyTolerance& tolerance) {
  const std::vector<std::size_t> known = known_frames(steadiness);
  std::vector<Fault> lights;
  std::vector<Fault> faults;
  for (const std::size_t i : known) {
    if (auto fault = light_fault(*steadiness[i], i, exposures_s[i], known, tolerance)) {
      lights.push_back(std::move(*fault));
    }
    if (auto fault = motion_fault(*steadiness[i], i, known, tolerance)) {
      faults.push_back(std::move(*fault));
    }
  }
  for (std::size_t i = 0; i < steadiness.size(); ++i) {
    if (!steadiness[i] || !steadiness[i]->blank) continue;
    faults.push_back({Fault::Kind::blank, i,
                      "it is black where the other frames of its stack show light: the lens was "
                      "covered, the projector off or the shutter closed"});
  }
  const std::optional<double> drift = drift_of(steadiness, known);
  if (!lights.empty() && drift) {
    lights = {{Fault::Kind::drift, known.back(),
               "the light drifted steadily, by " + percent(*drift) + " (" + brighter(*drift) +
                   ") since " + files[known.front()] + ", the first frame of its stack"}};
  }
  lights.insert(lights.end(), std::make_move_iterator(faults.begin()),
                std::make_move_iterator(faults.end()));
  return lights;
}

std::vector<double> steady_exposures(const Steadiness& steadiness,
                                     std::span<const double> exposures_s) {
  double sum = 0.0;
  double count = 0.0;
  for (const std::optional<FrameState>& state : steadiness) {
    if (!state || state->blank || std::abs(state->log_gain) > unremarkable) continue;
    sum += state->log_gain;
    count += 1.0;
  }
  const double kept = count > 0.0 ? sum / count : 0.0;
  std::vector<double> corrected(exposures_s.begin(), exposures_s.end());
  for (std::size_t i = 0; i < corrected.size(); ++i) {
    if (steadiness[i] && !steadiness[i]->blank)
      corrected[i] *= std::exp(steadiness[i]->log_gain - kept);
  }
  return corrected;
}

}  // namespace kappamu::capture
