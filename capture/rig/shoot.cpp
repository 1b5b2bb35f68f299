#include "capture/rig/shoot.h"

#include <algorithm>

#include "capture/response/response.h"
#include "capture/session/frames.h"
#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"
#include "io/image/image_file.h"

namespace kappamu::capture {
namespace {

constexpr double saturated_share = 0.002;

std::string numbered(const std::string& stem, std::size_t number) {
  return stem + formatted("%02zu", number);
}

class Shooter {
 public:
  Shooter(const Camera& camera, const Projector& projector, const CapturePlan& plan,
          const std::filesystem::path& folder, Progress& progress)
      : plan_(plan), progress_(progress) {
    session_.folder = folder;
    session_.description = plan.description;
    session_.setup = plan.setup;
    session_.sample = plan.sample;
    session_.camera = camera;
    session_.projector = projector;
    session_.calibration_station = plan.calibration_station;
    session_.pattern_station = plan.pattern_station;
    session_.calibration.board = plan.board;
    if (chessboards()) session_.calibration.projected_board = plan.projected_board;
    exposures_ = plan.exposures_s;
    target_exposures_ = plan.target_exposures_s.empty() ? exposures_ : plan.target_exposures_s;
    all_exposures_ = exposures_;
    all_exposures_.insert(all_exposures_.end(), target_exposures_.begin(), target_exposures_.end());
    std::sort(all_exposures_.begin(), all_exposures_.end());
    all_exposures_.erase(std::unique(all_exposures_.begin(), all_exposures_.end()),
                         all_exposures_.end());
  }

  // Without device and files: finds what contradicts itself before an hour of exposures is spent on
  // it, and counts the frames.
  const Session& rehearse() {
    check_plan();
    go_through();
    validate(session_);
    total_ = done_;
    return session_;
  }

  const Session& shoot(RigDevice& device) {
    rehearse();
    std::error_code ignored;
    std::filesystem::remove(session_.folder / "session.json", ignored);
    device_ = &device;
    go_through();
    write_session(session_);
    return session_;
  }

 private:
  bool rehearsing() const { return device_ == nullptr; }
  bool chessboards() const {
    return plan_.plane_light == PlaneLight::chessboard || plan_.plane_light == PlaneLight::both;
  }

  void go_through() {
    done_ = 0;
    session_.patterns.clear();
    session_.calibration.camera_boards.clear();
    session_.calibration.projector_planes.clear();
    session_.calibration.sample_views.clear();
    session_.calibration.dark.clear();
    session_.calibration.ambient.clear();
    dark();
    boards();
    planes();
    targets();
    views();
    patterns();
  }

  void check_plan() const {
    const std::string plan = "capture plan: ";
    if (exposures_.empty()) {
      throw InputError(plan + "exposures_s is empty; list at least one exposure time.");
    }
    for (const std::string& station : {plan_.calibration_station, plan_.pattern_station}) {
      require_plain_name(station, plan + "a station's name");
    }
    for (const PlannedPattern& pattern : plan_.patterns) {
      require_plain_name(pattern.id, plan + "the id of a pattern");
      if (pattern.image.width() != session_.projector.width ||
          pattern.image.height() != session_.projector.height || pattern.image.channels() != 1) {
        throw InputError(plan + "the image of pattern " + pattern.id + " is " +
                         std::to_string(pattern.image.width()) + " x " +
                         std::to_string(pattern.image.height()) + " in " +
                         std::to_string(pattern.image.channels()) +
                         " channels; make it grey and of the projector's " +
                         std::to_string(session_.projector.width) + " x " +
                         std::to_string(session_.projector.height) + ".");
      }
    }
  }

  void place(Subject subject, const std::string& station, Lighting lighting, int pose = 0,
             int poses = 1) {
    if (!rehearsing()) device_->place({subject, station, lighting, pose, poses});
  }
  void show(const Image<std::uint8_t>& image) {
    if (!rehearsing()) device_->show(image);
  }

  Frame save(const std::string& file, double exposure_s, const Image<std::uint16_t>& codes) {
    const Camera& camera = session_.camera;
    if (codes.width() != camera.width || codes.height() != camera.height || codes.channels() != 3) {
      throw InputError("camera: " + file + " came as " + std::to_string(codes.width()) + " x " +
                       std::to_string(codes.height()) + " in " + std::to_string(codes.channels()) +
                       " channels instead of " + std::to_string(camera.width) + " x " +
                       std::to_string(camera.height) + " in 3; correct the driver.");
    }
    io::write_code_image(session_.folder / file, codes, session_.camera.bit_depth);
    ++done_;
    progress_.update("shoot", static_cast<double>(done_) / static_cast<double>(total_), file);
    return {file, exposure_s};
  }
  Frame expose(const std::string& file, double exposure_s) {
    if (rehearsing()) {
      ++done_;
      return {file, exposure_s};
    }
    const Image<std::uint16_t> codes = device_->expose(exposure_s);
    return save(file, exposure_s, codes);
  }
  Stack stack(const std::string& stem, const std::vector<double>& exposures) {
    Stack frames;
    for (const double exposure : exposures) {
      frames.push_back(expose(stem + "_" + std::to_string(frames.size()) + ".png", exposure));
    }
    return frames;
  }

  // One frame at the longest time that hardly saturates, by trial; the trial is kept.
  Frame metered(const std::string& file) {
    if (rehearsing()) return expose(file, exposures_.front());
    const int saturated_from = saturation_code(session_.camera.bit_depth);
    // Begins where the last subject of the kind ended and goes to shorter times.
    std::size_t at = std::min(meter_, all_exposures_.size() - 1);
    for (;; --at) {
      const Image<std::uint16_t> codes = device_->expose(all_exposures_[at]);
      const auto saturated =
          std::count_if(codes.values().begin(), codes.values().end(),
                        [&](std::uint16_t code) { return code >= saturated_from; });
      const bool good =
          static_cast<double>(saturated) <= saturated_share * static_cast<double>(codes.size());
      if (!good && at > 0) continue;
      if (!good) {
        progress_.warn(file + " is saturated even at the plan's shortest exposure.");
      }
      meter_ = at;
      return save(file, all_exposures_[at], codes);
    }
  }
  void reset_meter() { meter_ = all_exposures_.size(); }

  void dark() {
    place(Subject::lens_covered, plan_.calibration_station, Lighting::projector);
    for (const double exposure : {all_exposures_.front(), all_exposures_.back()}) {
      for (int repeat = 0; repeat < plan_.dark_repeats; ++repeat) {
        std::vector<Frame>& frames = session_.calibration.dark;
        frames.push_back(expose(numbered("calibration/dark_", frames.size()) + ".png", exposure));
      }
    }
  }

  void boards() {
    reset_meter();
    for (int view = 0; view < plan_.camera_board_views; ++view) {
      place(Subject::board, plan_.calibration_station, Lighting::room, view,
            plan_.camera_board_views);
      session_.calibration.camera_boards.push_back(
          metered(numbered("calibration/board_", static_cast<std::size_t>(view)) + ".png"));
    }
  }

  void planes() {
    std::size_t ambient_meter = all_exposures_.size();
    std::size_t projected_meter = all_exposures_.size();
    for (int pose = 0; pose < plan_.projector_plane_poses; ++pose) {
      const std::string stem = numbered("calibration/plane_", static_cast<std::size_t>(pose));
      ProjectorPlane plane;
      place(Subject::plane, plan_.calibration_station, Lighting::room, pose,
            plan_.projector_plane_poses);
      meter_ = ambient_meter;
      plane.board = metered(stem + "_board.png");
      ambient_meter = meter_;
      place(Subject::plane, plan_.calibration_station, Lighting::projector, pose,
            plan_.projector_plane_poses);
      meter_ = projected_meter;
      if (chessboards()) {
        if (!rehearsing()) show(make_chessboard_image(session_.projector, plan_.projected_board));
        plane.projected = metered(stem + "_projected.png");
        projected_meter = meter_;
      }
      if (gray_codes(plan_.plane_light)) plane.gray_code = gray_code(stem);
      if (plan_.plane_light == PlaneLight::phase_shift) plane.phase_shift = phase_shift(stem);
      session_.calibration.projector_planes.push_back(plane);
    }
  }

  // All at one exposure time, that of the shortest period, which is bright all over the plane.
  std::vector<PhaseShift> phase_shift(const std::string& stem) {
    std::vector<PhaseShift> sets = usual_phase_shift(session_.projector);
    const std::size_t finest = finest_set(sets);
    const auto file = [&](std::size_t set, std::size_t n) {
      return numbered(stem + "_phase_", set * usual_phase_steps + n) + ".png";
    };
    std::optional<Frame> first;
    const auto shoot_set = [&](std::size_t s) {
      std::vector<Image<std::uint8_t>> images;
      if (!rehearsing()) {
        images = make_phase_shift_images(session_.projector, sets[s], usual_phase_steps);
      }
      for (std::size_t n = 0; n < usual_phase_steps; ++n) {
        if (!rehearsing()) show(images[n]);
        sets[s].frames.push_back(first ? expose(file(s, n), first->exposure_s)
                                       : metered(file(s, n)));
        if (!first) first = sets[s].frames.front();
      }
    };
    shoot_set(finest);
    for (std::size_t s = 0; s < sets.size(); ++s) {
      if (s != finest) shoot_set(s);
    }
    return sets;
  }

  // All at one exposure time, the white frame's, or codes would not compare.
  std::vector<Frame> gray_code(const std::string& stem) {
    const int count = gray_code_frames(session_.projector);
    std::vector<Image<std::uint8_t>> images;
    if (!rehearsing()) images = make_gray_code_images(session_.projector);
    const auto file = [&stem](int k) {
      return numbered(stem + "_gray_", static_cast<std::size_t>(k)) + ".png";
    };
    if (!rehearsing()) show(images[static_cast<std::size_t>(count) - 2]);
    const Frame white = metered(file(count - 2));
    std::vector<Frame> frames;
    for (int k = 0; k < count; ++k) {
      if (k == count - 2) {
        frames.push_back(white);
        continue;
      }
      if (!rehearsing()) show(images[static_cast<std::size_t>(k)]);
      frames.push_back(expose(file(k), white.exposure_s));
    }
    return frames;
  }

  void targets() {
    const Image<std::uint8_t> white = make_uniform_image(session_.projector, 255);
    if (plan_.white_reflectance) {
      place(Subject::white_target, plan_.calibration_station, Lighting::projector);
      show(white);
      WhiteTarget& target = session_.calibration.white_target.emplace();
      target.reflectance = *plan_.white_reflectance;
      target.frames = stack("calibration/white", target_exposures_);
      show(make_uniform_image(session_.projector, 0));
      target.black_frames = stack("calibration/black", target_exposures_);
      for (const std::uint8_t value : plan_.projector_levels) {
        show(make_uniform_image(session_.projector, value));
        target.levels.push_back(
            {value, stack("calibration/level_" + std::to_string(value), target_exposures_)});
      }
      if (plan_.ambient) {
        place(Subject::white_target, plan_.calibration_station, Lighting::none);
        target.off_frames = stack("calibration/off", target_exposures_);
      }
    }
    if (plan_.colour_chart) {
      place(Subject::colour_chart, plan_.calibration_station, Lighting::projector);
      show(white);
      session_.calibration.colour_chart =
          ColourChart{stack("calibration/chart", target_exposures_), std::nullopt};
    }
  }

  void views() {
    std::vector<std::pair<std::string, Face>> stations{
        {plan_.calibration_station, plan_.sample.lit_face}};
    if (plan_.pattern_station != plan_.calibration_station) {
      stations.emplace_back(plan_.pattern_station, plan_.sample.seen_face);
    }
    for (const auto& [station, face] : stations) {
      reset_meter();
      place(Subject::sample, station, Lighting::room);
      session_.calibration.sample_views.push_back(
          {station, face, metered("calibration/sample_" + station + ".png"), std::nullopt});
    }
  }

  void ambient(int time) {
    if (!plan_.ambient) return;
    place(Subject::sample, plan_.pattern_station, Lighting::none, time, 2);
    session_.calibration.ambient.push_back(
        stack("calibration/ambient_" + std::to_string(time), exposures_));
  }

  void patterns() {
    ambient(0);
    place(Subject::sample, plan_.pattern_station, Lighting::projector);
    for (const PlannedPattern& planned : plan_.patterns) {
      const std::string image = "patterns/" + planned.id + ".png";
      show(planned.image);
      if (!rehearsing()) io::write_image(session_.folder / image, planned.image);
      session_.patterns.push_back(
          {planned.id, image, planned.role, stack("frames/" + planned.id, exposures_)});
    }
    ambient(1);
  }

  RigDevice* device_ = nullptr;  // none while rehearsing
  const CapturePlan& plan_;
  Progress& progress_;
  Session session_;
  std::vector<double> exposures_;
  std::vector<double> target_exposures_;
  std::vector<double> all_exposures_;
  std::size_t meter_ = 0;  // exposure that metering tries first, cut to the last
  std::size_t done_ = 0;
  std::size_t total_ = 1;
};

}  // namespace

bool gray_codes(PlaneLight light) {
  return light == PlaneLight::gray_code || light == PlaneLight::both;
}

PlaneLight plane_light_from_string(const std::string& text) {
  if (const auto light = value_of(plane_light_names, text)) return *light;
  throw InputError("the light on the projector's planes is '" + text + "'; write " +
                   list_of(plane_light_names) + ".");
}

Session shoot_session(RigDevice& device, const CapturePlan& plan,
                      const std::filesystem::path& folder, Progress& progress) {
  return Shooter(device.camera(), device.projector(), plan, folder, progress).shoot(device);
}

Session rehearse_session(const Camera& camera, const Projector& projector, const CapturePlan& plan,
                         const std::filesystem::path& folder) {
  Progress nobody;
  return Shooter(camera, projector, plan, folder, nobody).rehearse();
}

}  // namespace kappamu::capture
