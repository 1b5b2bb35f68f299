#include "capture/rig/shoot.h"

#include <algorithm>
#include <utility>

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

// ", pose 1 of 6" for the operator, who counts from one.
std::string of(int pose, int poses) {
  return ", pose " + std::to_string(pose + 1) + " of " + std::to_string(poses);
}

// Names of what the projector shows.
constexpr const char* board_picture = "calibration/projected_board.png";

std::string level_picture(int value) {
  return "calibration/level_" + std::to_string(value) + ".png";
}

std::string gray_picture(std::size_t number) {
  return numbered("calibration/gray_code_", number) + ".png";
}

std::string phase_picture(std::size_t set, std::size_t step) {
  return "calibration/phase_" + std::to_string(set) + "_" + std::to_string(step) + ".png";
}

std::string pattern_picture(const PlannedPattern& pattern) {
  return "patterns/" + pattern.id + ".png";
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
  // it, and lists the frames.
  Rehearsal rehearse() {
    check_plan();
    make_pictures();
    go_through();
    validate(session_);
    return {session_, shots_, pictures_};
  }

  const Session& shoot(RigDevice& device) {
    total_ = rehearse().shots.size();
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

  void make_pictures() {
    const auto uniform = [this](std::uint8_t value) {
      return make_uniform_image(session_.projector, value);
    };
    pictures_ = {{"black", uniform(0)}, {"white", uniform(255)}};
    for (const std::uint8_t value : plan_.projector_levels) {
      pictures_[level_picture(value)] = uniform(value);
    }
    if (chessboards()) {
      pictures_[board_picture] = make_chessboard_image(session_.projector, plan_.projected_board);
    }
    if (gray_codes(plan_.plane_light)) {
      std::vector<Image<std::uint8_t>> code = make_gray_code_images(session_.projector);
      for (std::size_t k = 0; k < code.size(); ++k) {
        pictures_[gray_picture(k)] = std::move(code[k]);
      }
    }
    if (plan_.plane_light == PlaneLight::phase_shift) {
      const std::vector<PhaseShift> sets = usual_phase_shift(session_.projector);
      for (std::size_t s = 0; s < sets.size(); ++s) {
        auto images = make_phase_shift_images(session_.projector, sets[s], usual_phase_steps);
        for (std::size_t n = 0; n < images.size(); ++n) {
          pictures_[phase_picture(s, n)] = std::move(images[n]);
        }
      }
    }
    for (const PlannedPattern& pattern : plan_.patterns) {
      pictures_[pattern_picture(pattern)] = pattern.image;
    }
  }

  void go_through() {
    shots_.clear();
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

  // `told` and `shows`: what stands there and what the projector throws on it, in words.
  void place(const Scene& scene, const std::string& told, const std::string& shows) {
    now_.subject = told;
    now_.station = scene.station;
    now_.show = shows;
    if (!rehearsing()) device_->place(scene);
  }
  void show(const std::string& picture) {
    now_.show = picture;
    if (!rehearsing()) device_->show(pictures_.at(picture));
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
    const Frame frame = list(file, exposure_s);
    progress_.update("shoot", static_cast<double>(shots_.size()) / static_cast<double>(total_),
                     file);
    return frame;
  }
  Frame list(const std::string& file, double exposure_s, bool metered = false) {
    Shot& shot = shots_.emplace_back(now_);
    shot.file = file;
    shot.exposure_s = exposure_s;
    shot.metered = metered;
    return {file, exposure_s};
  }
  Frame expose(const std::string& file, double exposure_s) {
    if (rehearsing()) return list(file, exposure_s);
    return save(file, exposure_s, device_->expose(exposure_s));
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
    if (rehearsing()) return list(file, exposures_.front(), true);
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
    place({Subject::lens_covered, plan_.calibration_station}, "lens covered", "black");
    for (const double exposure : {all_exposures_.front(), all_exposures_.back()}) {
      for (int repeat = 0; repeat < plan_.dark_repeats; ++repeat) {
        std::vector<Frame>& frames = session_.calibration.dark;
        frames.push_back(expose(numbered("calibration/dark_", frames.size()) + ".png", exposure));
      }
    }
  }

  void boards() {
    reset_meter();
    const int views = plan_.camera_board_views;
    for (int view = 0; view < views; ++view) {
      place(
          {Subject::board, plan_.calibration_station, Lighting::room, view, views},
          "printed board" + of(view, views) + ": over the whole frame, some tilted, room light on",
          "off");
      session_.calibration.camera_boards.push_back(
          metered(numbered("calibration/board_", static_cast<std::size_t>(view)) + ".png"));
    }
  }

  void planes() {
    std::size_t ambient_meter = all_exposures_.size();
    std::size_t projected_meter = all_exposures_.size();
    const int poses = plan_.projector_plane_poses;
    for (int pose = 0; pose < poses; ++pose) {
      const std::string stem = numbered("calibration/plane_", static_cast<std::size_t>(pose));
      ProjectorPlane plane;
      place({Subject::plane, plan_.calibration_station, Lighting::room, pose, poses},
            "plane with printed board and blank part" + of(pose, poses) + ", room light on",
            "black");
      meter_ = ambient_meter;
      plane.board = metered(stem + "_board.png");
      ambient_meter = meter_;
      place({Subject::plane, plan_.calibration_station, Lighting::projector, pose, poses},
            "the same plane, unmoved, room light off", "black");
      meter_ = projected_meter;
      if (chessboards()) {
        show(board_picture);
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
      for (std::size_t n = 0; n < usual_phase_steps; ++n) {
        show(phase_picture(s, n));
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
    const auto count = static_cast<std::size_t>(gray_code_frames(session_.projector));
    const std::size_t white = count - 2;
    const auto file = [&stem](std::size_t k) { return numbered(stem + "_gray_", k) + ".png"; };
    std::vector<Frame> frames(count);
    show(gray_picture(white));
    frames[white] = metered(file(white));
    for (std::size_t k = 0; k < count; ++k) {
      if (k == white) continue;
      show(gray_picture(k));
      frames[k] = expose(file(k), frames[white].exposure_s);
    }
    return frames;
  }

  void targets() {
    if (plan_.white_reflectance) {
      place({Subject::white_target, plan_.calibration_station},
            "white target in the plane of the lit face, room light off", "black");
      show("white");
      WhiteTarget& target = session_.calibration.white_target.emplace();
      target.reflectance = *plan_.white_reflectance;
      target.frames = stack("calibration/white", target_exposures_);
      now_.subject = "white target, unmoved";
      show("black");
      target.black_frames = stack("calibration/black", target_exposures_);
      for (const std::uint8_t value : plan_.projector_levels) {
        show(level_picture(value));
        target.levels.push_back(
            {value, stack("calibration/level_" + std::to_string(value), target_exposures_)});
      }
      if (plan_.ambient) {
        place({Subject::white_target, plan_.calibration_station, Lighting::none},
              "white target, unmoved, projector's lens capped", "anything");
        target.off_frames = stack("calibration/off", target_exposures_);
      }
    }
    if (plan_.colour_chart) {
      place({Subject::colour_chart, plan_.calibration_station},
            "colour chart in the plane of the lit face", "black");
      show("white");
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
      place({Subject::sample, station, Lighting::room},
            "sample before a dark background, room light on", "black");
      session_.calibration.sample_views.push_back(
          {station, face, metered("calibration/sample_" + station + ".png"), std::nullopt});
    }
  }

  void ambient(int time) {
    if (!plan_.ambient) return;
    place({Subject::sample, plan_.pattern_station, Lighting::none, time, 2},
          "sample, projector's lens capped, room light as under the patterns", "anything");
    session_.calibration.ambient.push_back(
        stack("calibration/ambient_" + std::to_string(time), exposures_));
  }

  void patterns() {
    ambient(0);
    place({Subject::sample, plan_.pattern_station}, "sample, room light off", "black");
    for (const PlannedPattern& planned : plan_.patterns) {
      const std::string image = pattern_picture(planned);
      show(image);
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
  std::map<std::string, Image<std::uint8_t>> pictures_;
  Shot now_;  // what stands there and what is shown
  std::vector<Shot> shots_;
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

Rehearsal rehearse_session(const Camera& camera, const Projector& projector,
                           const CapturePlan& plan, const std::filesystem::path& folder) {
  Progress nobody;
  return Shooter(camera, projector, plan, folder, nobody).rehearse();
}

}  // namespace kappamu::capture
