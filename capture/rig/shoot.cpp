#include "capture/rig/shoot.h"

#include <utility>

#include "capture/rig/photographer.h"
#include "capture/rig/shown_pictures.h"
#include "capture/session/frames.h"
#include "io/image/image_file.h"

namespace kappamu::capture {
namespace {

// ", pose 1 of 6" for the operator, who counts from one.
std::string of(int pose, int poses) {
  return ", pose " + std::to_string(pose + 1) + " of " + std::to_string(poses);
}

class Shooter : Photographer {
 public:
  using Photographer::Photographer;

  // Without device and files: finds what contradicts itself before an hour of exposures is spent on
  // it, and lists the frames.
  Rehearsal rehearse() {
    check_plan(plan_, session_.projector);
    pictures_ = shown_pictures(plan_, session_.projector);
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
      if (chessboards(plan_.plane_light)) {
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
    if (plan_.both_faces) patterns_on_lit_face();
  }

  void patterns_on_lit_face() {
    place({Subject::sample, plan_.calibration_station}, "sample, room light off", "black");
    const std::vector<Pattern> seen_behind = session_.patterns;
    for (const Pattern& pattern : seen_behind) {
      if (pattern.role != PatternRole::fit) continue;
      show(pattern.image);
      Pattern on_lit_face = pattern;
      on_lit_face.id += "_lit";
      on_lit_face.station = plan_.calibration_station;
      on_lit_face.frames = stack("frames/" + on_lit_face.id, exposures_);
      session_.patterns.push_back(std::move(on_lit_face));
    }
  }
};

}  // namespace

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
