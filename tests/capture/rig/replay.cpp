#include "tests/capture/rig/replay.h"

#include <algorithm>
#include <cmath>

#include "capture/rig/shoot.h"
#include "capture/session/frames.h"
#include "core/error.h"
#include "core/shown_text.h"
#include "io/image/image_file.h"

namespace kappamu::capture {
namespace {

constexpr double equal_times = 1e-6;

bool is_uniform(const Image<std::uint8_t>& image, std::uint8_t value) {
  return std::all_of(image.values().begin(), image.values().end(),
                     [value](std::uint8_t pixel) { return pixel == value; });
}

}  // namespace

FolderReplay::FolderReplay(const std::filesystem::path& folder) : session_(read_session(folder)) {}

void FolderReplay::place(const Scene& scene) {
  scene_ = scene;
  show(Image<std::uint8_t>(session_.projector.width, session_.projector.height, 1, 0));
}

void FolderReplay::show(const Image<std::uint8_t>& image) {
  shown_ = image;
  exposed_ = 0;
}

const Pattern* FolderReplay::shown_pattern() const {
  for (const Pattern& pattern : session_.patterns) {
    const Image<std::uint16_t> image = io::read_code_image(session_.folder / pattern.image);
    const bool same =
        image.size() == shown_.size() &&
        std::equal(image.values().begin(), image.values().end(), shown_.values().begin());
    if (same) return &pattern;
  }
  return nullptr;
}

std::vector<Frame> FolderReplay::frames_of_scene() const {
  const Calibration& shots = session_.calibration;
  const auto pose = static_cast<std::size_t>(scene_.pose);
  const auto first_of = [&](const auto& list) { return pose < list.size(); };
  switch (scene_.subject) {
    case Subject::lens_covered:
      return shots.dark;
    case Subject::board:
      return first_of(shots.camera_boards) ? std::vector{shots.camera_boards[pose]}
                                           : std::vector<Frame>();
    case Subject::plane: {
      if (!first_of(shots.projector_planes)) return {};
      const ProjectorPlane& plane = shots.projector_planes[pose];
      if (scene_.lighting == Lighting::room) return {plane.board};
      if (!plane.gray_code.empty()) {
        const std::vector<Image<std::uint8_t>> code = make_gray_code_images(session_.projector);
        const auto same = std::find_if(code.begin(), code.end(), [&](const auto& image) {
          return image.values() == shown_.values();
        });
        if (same != code.end()) {
          return {plane.gray_code[static_cast<std::size_t>(same - code.begin())]};
        }
      }
      for (const PhaseShift& set : plane.phase_shift) {
        const auto steps =
            make_phase_shift_images(session_.projector, set, static_cast<int>(set.frames.size()));
        for (std::size_t n = 0; n < steps.size(); ++n) {
          if (steps[n].values() == shown_.values()) return {set.frames[n]};
        }
      }
      return plane.projected ? std::vector{*plane.projected} : std::vector<Frame>();
    }
    case Subject::white_target:
      if (!shots.white_target) return {};
      if (scene_.lighting == Lighting::none) return shots.white_target->off_frames;
      if (is_uniform(shown_, 0)) return shots.white_target->black_frames;
      for (const ProjectorLevel& level : shots.white_target->levels) {
        if (is_uniform(shown_, static_cast<std::uint8_t>(level.value))) return level.frames;
      }
      return shots.white_target->frames;
    case Subject::colour_chart:
      return shots.colour_chart ? shots.colour_chart->frames : std::vector<Frame>();
    default:
      break;
  }
  if (scene_.lighting == Lighting::room) {
    for (const SampleView& view : shots.sample_views) {
      if (view.station == scene_.station) return {view.frame};
    }
    return {};
  }
  if (scene_.lighting == Lighting::none) {
    return pose < shots.ambient.size() ? shots.ambient[pose] : std::vector<Frame>();
  }
  const Pattern* pattern = shown_pattern();
  return pattern != nullptr ? pattern->frames : std::vector<Frame>();
}

Image<std::uint16_t> FolderReplay::expose(double exposure_s) {
  const std::vector<Frame> frames = frames_of_scene();
  const std::string file = (session_.folder / "session.json").string();
  if (frames.empty()) {
    throw InputError(file + ": lists no photograph of what is asked for (station '" +
                     scene_.station + "', pose " + std::to_string(scene_.pose) +
                     "); replay with the plan it was photographed by.");
  }
  std::vector<const Frame*> fitting;
  for (const Frame& frame : frames) {
    if (std::abs(frame.exposure_s - exposure_s) <= equal_times * exposure_s) {
      fitting.push_back(&frame);
    }
  }
  if (!fitting.empty()) return load_frame(session_, *fitting[exposed_++ % fitting.size()]);
  if (frames.size() == 1 && exposure_s > frames.front().exposure_s) {
    const auto white = static_cast<std::uint16_t>(largest_code(session_.camera));
    return {session_.camera.width, session_.camera.height,
            static_cast<int>(session_.channels.size()), white};
  }
  throw InputError(file + ": " + frames.front().file + " and its stack have no exposure of " +
                   shown_number(exposure_s, "%.6g s") +
                   "; replay with the plan it was photographed by.");
}

}  // namespace kappamu::capture
