#include "calib/calibrate.h"

#include <algorithm>
#include <cmath>

#include "calib/calibrate_lenses.h"
#include "calib/light/shared_error.h"
#include "calib/linear_frame.h"
#include "calib/projector/view_checks.h"
#include "calib/sample/face.h"
#include "calib/sample/surroundings.h"
#include "capture/radiance/ambient.h"
#include "capture/radiance/chart_search.h"
#include "capture/radiance/merge.h"
#include "capture/response/radiometry.h"
#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::calib {
namespace {

const capture::SampleView& view_from(const capture::Session& session, const std::string& station,
                                     Face face) {
  const auto& views = session.calibration.sample_views;
  const auto found = std::find_if(views.begin(), views.end(), [&](const capture::SampleView& v) {
    return v.station == station && v.face == face;
  });
  if (found == views.end()) {
    throw InputError((session.folder / "session.json").string() +
                     ": calibration.sample_views has no view of face " + to_string(face) +
                     " from station \"" + station + "\"; photograph the sample from there");
  }
  return *found;
}

SamplePose pose_in(const capture::Session& session, const capture::SampleView& view,
                   const CalibrationResult& result) {
  const GridShape grid = session.sample.shape();
  SamplePose pose;
  if (view.corners_px) {
    std::array<Eigen::Vector2d, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k] = {(*view.corners_px)[k][0], (*view.corners_px)[k][1]};
    }
    pose = pose_from_corners(corners, result.camera.lens, grid, view.face, view.frame.file,
                             result.camera.covariance);
  } else {
    pose = find_sample_pose(load_linear(session, view.frame, result.radiometry), result.camera.lens,
                            grid, view.face, view.frame.file, result.camera.covariance);
  }
  pose.station = view.station;
  return pose;
}

/// Light scale, flat field, the projector's black and response, room light. Returns the target
/// under full white and the room's light.
capture::HdrImage calibrate_white(const capture::Session& session,
                                  const capture::MergeOptions& merge, Stages& stages,
                                  CalibrationResult& result, std::vector<std::string>& notes) {
  const capture::WhiteTarget& target = *session.calibration.white_target;
  const std::string name =
      (session.folder / "session.json").string() + ": calibration.white_target";
  enum class Light { expected, none };
  const auto picture = [&](const capture::Stack& frames, const std::string& label, Light light) {
    capture::MergeOptions options = merge;
    options.require_light = light == Light::expected;
    return capture::merge_stack(session, frames, label, result.radiometry, options, &notes);
  };
  capture::HdrImage white = picture(target.frames, "white target", Light::expected);
  capture::HdrImage projected = white;
  std::optional<capture::HdrImage> black;
  if (target.black_frames.empty()) {
    stages.warn(
        "no white_target.black_frames: light from the projector's black pixels is taken as zero.");
  } else {
    black = picture(target.black_frames, "white target under black", Light::none);
  }
  std::optional<capture::HdrImage> off;
  if (!target.off_frames.empty()) {
    off = picture(target.off_frames, "white target, projector off", Light::none);
    capture::take_off(*off, projected);
    if (black) capture::take_off(*off, *black);
  }
  const Rigid& pose = result.calibration_pose.camera_from_sample;
  const GridShape grid = session.sample.shape();
  const Face lit = session.sample.lit_face;
  result.white = measure_white(projected, black, target.reflectance, result.camera.lens, pose, grid,
                               lit, name);
  result.scale = result.white.scale;
  const auto signal = [&](const capture::HdrImage& seen) {
    return centre_signal(seen, result.white.flat, result.camera.lens, pose, grid, lit, name);
  };
  const std::vector<double> full = signal(projected);
  const std::vector<double> room =
      off ? signal(*off) : std::vector<double>(session.channels.size(), 0.0);
  if (off) {
    double sum = 0.0;
    for (std::size_t c = 0; c < room.size(); ++c) sum += room[c] / full[c];
    result.white.room_light = sum / static_cast<double>(room.size());
  }
  if (target.levels.empty()) return white;
  std::vector<int> values{0};
  std::vector<std::vector<double>> signals{black ? signal(*black)
                                                 : std::vector<double>(room.size(), 0.0)};
  double shared = 0.0;
  for (const capture::ProjectorLevel& level : target.levels) {
    values.push_back(level.value);
    capture::HdrImage seen =
        picture(level.frames, "white target under " + std::to_string(level.value), Light::none);
    if (off) capture::take_off(*off, seen);
    signals.push_back(signal(seen));
    for (const FaceMap& map : ratio_on_face(seen, projected, result.camera.lens, pose, grid, lit)) {
      // Both pictures err.
      shared += 0.5 * std::pow(octave_error(map), 2) /
                static_cast<double>(target.levels.size() * room.size());
    }
  }
  if (std::isfinite(shared)) result.white.level_error = std::sqrt(shared);
  values.push_back(255);
  signals.push_back(full);
  result.projector_curve = curve_from_signals(values, signals);
  constexpr double suspicious = 0.01;
  if (result.projector_curve->channel_spread() > suspicious) {
    stages.warn("the projector's channels answer to pixel values differently, by up to " +
                shown_number(100.0 * result.projector_curve->channel_spread(), "%.1f") +
                " % of white: patterns of values between black and white have their mean for "
                "light.");
  }
  return white;
}

/// Centres [px] of the chart's corner patches, as stated or found.
std::array<std::array<double, 2>, 4> chart_corners(const capture::Session& session,
                                                   const capture::ColourChart& chart,
                                                   const std::string& name) {
  if (chart.corners_px) return *chart.corners_px;
  const auto place = capture::find_chart_place(session, chart.frames);
  if (!place) {
    throw InputError(name +
                     ": no colour chart found; show all 24 patches, sharp and in colour, or give "
                     "the centres of its corner patches in calibration.colour_chart.corners_px of "
                     "session.json");
  }
  return place->corners_px;
}

void calibrate_light(const capture::Session& session, capture::MergeOptions merge, Stages& stages,
                     CalibrationResult& result) {
  std::vector<std::string> notes;
  const capture::Calibration& shots = session.calibration;
  const std::string json = (session.folder / "session.json").string();
  std::optional<capture::HdrImage> white;
  const double reflectance = shots.white_target ? shots.white_target->reflectance : 1.0;
  const std::string chart_name = json + ": calibration.colour_chart";
  Surrounding seen;  // of targets, what shows the sample's place and the chart
  add_block(result.camera.lens, result.calibration_pose.camera_from_sample, session.sample.shape(),
            seen);
  std::optional<ChartPatches> patches;
  if (shots.colour_chart) {
    std::array<Eigen::Vector2d, 4> corners;
    const auto corners_px = chart_corners(session, *shots.colour_chart, chart_name);
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k] = {corners_px[k][0], corners_px[k][1]};
      seen.add(corners_px[k][0], corners_px[k][1]);
    }
    patches = chart_from_corners(corners);
  }
  merge.part = with_surroundings(seen, result.camera.lens);
  if (shots.white_target) white = calibrate_white(session, merge, stages, result, notes);
  if (shots.colour_chart) {
    const capture::HdrImage chart = capture::merge_stack(
        session, shots.colour_chart->frames, "colour chart", result.radiometry, merge, &notes);
    result.chart =
        measure_chart(chart, *patches, white ? &*white : nullptr, reflectance, result.white.scale);
    if (!white) {
      if (result.chart->scale.empty()) {
        throw InputError(chart_name + ": no neutral patch can be used; add shorter exposures");
      }
      result.scale = result.chart->scale;
      stages.warn(
          "no white target: the scale comes from the colour chart's neutral patches, and "
          "the projector's light is taken as even over the lit face.");
    } else {
      constexpr double suspicious = 0.03;
      if (result.chart->residual_rms > suspicious) {
        stages.warn("white target and colour chart disagree by " +
                    shown_number(100.0 * result.chart->residual_rms, "%.1f") +
                    " % (root mean square over the neutral patches): check "
                    "white_target.reflectance and that both were in the plane of the lit face.");
      }
    }
  }
  for (const std::string& note : notes) stages.warn(note);
  if (result.scale.empty()) {
    throw InputError(
        json +
        ": calibration has neither white_target nor colour_chart, so that radiance has "
        "no scale; photograph one of them");
  }
}

}  // namespace

void calibrate_sample(const capture::Session& session, CalibrationResult& result,
                      Progress& progress, const capture::MergeOptions& hdr) {
  Stages stages(result, progress);
  stages.run("pose", 0.7, [&] {
    const Face lit = session.sample.lit_face;
    const Face seen = session.sample.seen_face;
    result.calibration_pose =
        pose_in(session, view_from(session, session.calibration_station, lit), result);
    const bool same = session.pattern_station == session.calibration_station && lit == seen;
    result.pattern_pose =
        same ? result.calibration_pose
             : pose_in(session, view_from(session, session.pattern_station, seen), result);
    for (const std::string& sentence : check_scale(result.projector.station_from_plane,
                                                   result.calibration_pose.camera_from_sample,
                                                   session.calibration.board.square_mm)) {
      stages.warn(sentence);
    }
    result.projector_from_sample =
        result.projector.projector_from_station * result.calibration_pose.camera_from_sample;
  });
  stages.run("light", 0.8, [&] { calibrate_light(session, hdr, stages, result); });
}

CalibrationResult calibrate(const capture::Session& session, Progress& progress,
                            const capture::MergeOptions& hdr) {
  CalibrationResult result;
  Stages stages(result, progress);
  stages.run("response", 0.0,
             [&] { result.radiometry = capture::find_radiometry(session, progress); });
  std::optional<KnownLens> known;
  if (const auto& lens = session.calibration.lens) {
    known =
        read_known_lens(session.folder / lens->file, lens->held ? LensUse::held : LensUse::start);
  }
  const JointCalibration joint = calibrate_lenses(session, stages, result, known);
  calibrate_sample(session, result, progress, hdr);
  const GridShape grid = session.sample.shape();
  const auto corners = face_corners(grid, session.sample.seen_face);
  result.camera_uncertainty = projection_uncertainty(
      result.camera,
      (result.pattern_pose.camera_from_sample * (0.5 * (corners[0] + corners[2]))).z());
  for (const Eigen::Vector3d& corner : face_corners(grid, session.sample.lit_face)) {
    const Eigen::Vector3d point = result.calibration_pose.camera_from_sample * corner;
    const Eigen::Matrix2d covariance = projector_covariance(joint, point);
    result.projector_deviation_px =
        std::max(result.projector_deviation_px, std::sqrt(covariance.trace() / 2.0));
  }
  progress.update("calibrate", 1.0, "done");
  return result;
}

CalibrationResult calibrate_lenses_alone(const capture::Session& session, Progress& progress,
                                         const std::optional<KnownLens>& known) {
  CalibrationResult result;
  Stages stages(result, progress);
  const capture::Camera& camera = session.camera;
  result.radiometry.bit_depth = camera.bit_depth;
  std::vector<double> linear = capture::linear_response(camera.bit_depth, 0.0, camera.white_level);
  if (camera.encoding == capture::Encoding::response) {
    // IEC 61966-2-1.
    for (double& v : linear) v = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  result.radiometry.response.linear.assign(session.channels.size(), linear);
  calibrate_lenses(session, stages, result, known);
  const std::vector<Rigid>& boards = result.camera.camera_from_board;
  double distance = 0.0;
  for (const Rigid& board : boards) distance += board.translation.z();
  result.camera_uncertainty =
      projection_uncertainty(result.camera, distance / static_cast<double>(boards.size()));
  progress.update("calibrate", 1.0, "done");
  return result;
}

}  // namespace kappamu::calib
