#include "capture/response/radiometry.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/response/dark_frames.h"
#include "capture/response/photon_transfer.h"
#include "capture/session/frames.h"
#include "capture/session/frames_at_once.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/shown_text.h"

namespace kappamu::capture {
namespace {

// Stacks the response is recovered from, beside white target and chart; more change the curve by
// less than its residual.
constexpr std::size_t response_pattern_stacks = 3;
// Where neither the session nor its frames tell: a small industrial sensor's full well.
constexpr double default_electrons_full_scale = 10000.0;

std::vector<ExposedFrame> load_stack(const Session& session, const Stack& stack) {
  std::vector<ExposedFrame> frames(stack.size());
  for_rows(
      static_cast<int>(stack.size()),
      [&](int j) {
        const Frame& frame = stack[static_cast<std::size_t>(j)];
        frames[static_cast<std::size_t>(j)] = {load_sites(session, frame), frame.exposure_s};
      },
      frames_at_once);
  return frames;
}

std::vector<const Stack*> informative_stacks(const Session& session) {
  std::vector<const Stack*> stacks;
  const Calibration& calibration = session.calibration;
  if (calibration.white_target) stacks.push_back(&calibration.white_target->frames);
  if (calibration.colour_chart) stacks.push_back(&calibration.colour_chart->frames);
  const std::size_t count = session.patterns.size();
  const std::size_t wanted = std::min(count, response_pattern_stacks);
  for (std::size_t i = 0; i < wanted; ++i) {
    stacks.push_back(&session.patterns[i * count / wanted].frames);
  }
  return stacks;
}

void recover_responses(const Session& session, Progress& progress, Radiometry& radiometry) {
  const std::size_t channels = session.channels.size();
  std::vector<std::vector<ResponseSample>> samples(channels);
  const std::vector<const Stack*> stacks = informative_stacks(session);
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    progress.update("response", static_cast<double>(i) / static_cast<double>(stacks.size()),
                    "stack " + std::to_string(i + 1) + " of " + std::to_string(stacks.size()));
    const std::vector<ExposedFrame> frames = load_stack(session, *stacks[i]);
    for_rows(static_cast<int>(channels), [&](int c) {
      collect_response_samples(frames, c, radiometry.bit_depth,
                               samples[static_cast<std::size_t>(c)]);
    });
  }
  for (std::size_t c = 0; c < channels; ++c) {
    const std::string name = shown_session(session) + ": channel " + session.channels[c];
    RecoveredResponse recovered =
        recover_response(samples[c], radiometry.bit_depth, radiometry.black_level[c], name);
    radiometry.response.linear.push_back(std::move(recovered.linear));
    radiometry.reports.push_back(recovered.report);
  }
  progress.update("response", 1.0, "");
}

double slope_at(const std::vector<double>& response, double code) {
  const auto low = static_cast<std::size_t>(
      std::clamp(std::floor(code), 0.0, static_cast<double>(response.size()) - 2.0));
  return response[low + 1] - response[low];
}

void find_noise(const Session& session, const std::vector<DarkLevel>& dark, Radiometry& radiometry,
                Progress& progress) {
  const Camera& camera = session.camera;
  const Stack& stack = session.patterns[session.patterns.size() / 2].frames;
  const bool floats = std::any_of(stack.begin(), stack.end(), [&](const Frame& frame) {
    return is_float_frame(session, frame);
  });
  std::vector<ExposedFrame> frames;
  if (!camera.electrons_full_scale && !floats) frames = load_stack(session, stack);
  for (std::size_t c = 0; c < session.channels.size(); ++c) {
    const std::vector<double>& response = radiometry.response.linear[c];
    constexpr double rounding_variance = 1.0 / 12.0;
    const double codes =
        std::sqrt(std::max(dark[c].deviation * dark[c].deviation - rounding_variance, 0.0));
    const double read = codes * slope_at(response, dark[c].code);
    Noise noise;
    noise.estimated = !camera.electrons_full_scale || !camera.read_noise_electrons;
    std::optional<double> electrons = camera.electrons_full_scale;
    if (!electrons) {
      electrons = electrons_at_full_scale(frames, static_cast<int>(c), response, read);
    }
    if (!electrons) {
      progress.warn("The frames do not determine the shot noise of channel " + session.channels[c] +
                    "; 10000 electrons at full scale are assumed (camera.electrons_full_scale).");
    }
    noise.electrons_full_scale = electrons.value_or(default_electrons_full_scale);
    noise.read_noise_electrons =
        camera.read_noise_electrons.value_or(read * noise.electrons_full_scale);
    radiometry.noise.push_back(noise);
  }
}

}  // namespace

std::vector<double> linear_response(int bit_depth, double black_level,
                                    std::optional<int> white_level) {
  const int top = (1 << bit_depth) - 1;
  const int white = white_level.value_or(top);
  std::vector<double> linear(static_cast<std::size_t>(top) + 1, 1.0);
  for (int code = 0; code < white; ++code) {
    linear[static_cast<std::size_t>(code)] = (code - black_level) / (white - black_level);
  }
  return linear;
}

Radiometry find_radiometry(const Session& session, Progress& progress) {
  Radiometry radiometry;
  radiometry.bit_depth = session.camera.bit_depth;
  const bool measured = !session.calibration.dark.empty();
  const std::vector<DarkLevel> dark =
      measured ? dark_levels(session)
               : dark_levels_of_stack(session, session.patterns.front().frames);
  if (!measured) {
    progress.warn("there is no dark frame; the frames themselves put black at code " +
                  shown_number(dark.front().code, "%.1f") +
                  ": photograph the covered lens (dark_0) for dim light to be right.");
  }
  for (std::size_t c = 0; c < dark.size(); ++c) {
    const double level = dark[c].code;
    if (measured &&
        level > 0.5 * session.camera.white_level.value_or(largest_code(session.camera))) {
      throw InputError(shown_session(session) + ": calibration.dark shows light (channel " +
                       session.channels[c] +
                       " is above half of full scale); cover the lens and shoot it again.");
    }
    radiometry.black_level.push_back(level);
  }
  if (session.camera.encoding == Encoding::linear) {
    for (const double level : radiometry.black_level) {
      radiometry.response.linear.push_back(
          linear_response(radiometry.bit_depth, level, session.camera.white_level));
    }
  } else {
    recover_responses(session, progress, radiometry);
  }
  find_noise(session, dark, radiometry, progress);
  return radiometry;
}

}  // namespace kappamu::capture
