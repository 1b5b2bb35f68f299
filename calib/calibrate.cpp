#include "calib/calibrate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "calib/projector/bundle_adjustment.h"
#include "calib/projector/gray_code.h"
#include "calib/projector/view_checks.h"
#include "calib/sample/face.h"
#include "calib/targets/chessboard.h"
#include "calib/targets/find_board.h"
#include "capture/radiance/ambient.h"
#include "capture/radiance/merge.h"
#include "capture/session/frames.h"
#include "core/error.h"

namespace kappamu::calib {
namespace {

std::string rounded(double value, const char* format = "%.2f") {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

/// Stages of the work: progress, time, warnings.
class Stages {
 public:
  Stages(CalibrationResult& result, Progress& progress) : result_(result), progress_(progress) {}

  template <class Work>
  void run(const std::string& stage, double from, const Work& work) {
    progress_.update("calibrate", from, stage);
    const auto start = std::chrono::steady_clock::now();
    work();
    result_.seconds[stage] +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  void warn(const std::string& sentence) {
    result_.warnings.push_back(sentence);
    progress_.warn(sentence);
  }

 private:
  CalibrationResult& result_;
  Progress& progress_;
};

/// A frame as luminance in codes, for bits that are light or dark.
Image<float> load_codes(const capture::Session& session, const capture::Frame& frame) {
  const Image<std::uint16_t> codes = capture::load_frame(session, frame);
  Image<float> image(codes.width(), codes.height(), codes.channels());
  std::transform(codes.values().begin(), codes.values().end(), image.values().begin(),
                 [](std::uint16_t code) { return static_cast<float>(code); });
  return to_grey(image);
}

/// A frame as luminance, linear in light, where an edge is symmetric.
Image<float> load_linear(const capture::Session& session, const capture::Frame& frame,
                         const capture::Radiometry& radiometry) {
  if (capture::is_float_frame(frame)) return to_grey(capture::load_float_frame(session, frame));
  const Image<std::uint16_t> codes = capture::load_frame(session, frame);
  Image<float> image(codes.width(), codes.height(), codes.channels());
  for (std::size_t k = 0; k < codes.size(); ++k) {
    const auto channel = k % static_cast<std::size_t>(codes.channels());
    image.values()[k] = static_cast<float>(radiometry.response.linear[channel][codes.values()[k]]);
  }
  return to_grey(image);
}

BoardCorners printed_corners(const capture::Session& session, const capture::Frame& frame,
                             const capture::Radiometry& radiometry) {
  return find_board(load_linear(session, frame, radiometry), session.calibration.board, frame.file);
}

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

/// The planes with the points that their Gray codes locate for projected corners.
std::vector<PlaneView> read_gray_codes(const capture::Session& session,
                                       const capture::ProjectedBoard& lattice,
                                       std::vector<PlaneView> planes, CalibrationResult& result) {
  constexpr int shown_px = 160;  // longest side of the quality map that is kept
  for (std::size_t p = 0; p < planes.size(); ++p) {
    std::vector<Image<float>> frames;
    for (const capture::Frame& frame : session.calibration.projector_planes[p].gray_code) {
      frames.push_back(load_codes(session, frame));
    }
    const GrayCodeMap map = decode_gray_code(frames, session.projector);
    planes[p].name = session.calibration.projector_planes[p].gray_code.front().file;
    planes[p].projected = points_on_plane(gray_code_corners(map, lattice, planes[p].name),
                                          planes[p].printed, session.camera.width, planes[p].name);
    result.gray_code.push_back({planes[p].name, map.legible_share(),
                                static_cast<int>(planes[p].projected.pixels.size()),
                                block_means(map.quality, shown_px)});
  }
  return planes;
}

JointCalibration calibrate_lenses(const capture::Session& session, Stages& stages,
                                  CalibrationResult& result) {
  JointCalibration joint;
  const capture::Calibration& shots = session.calibration;
  std::vector<BoardView> views;
  std::vector<PlaneView> planes;
  stages.run("camera", 0.3, [&] {
    for (const capture::Frame& frame : shots.camera_boards) {
      views.push_back({frame.file, printed_corners(session, frame, result.radiometry)});
    }
    // The planes' printed boards are seen through the same lens: they help it, too.
    for (const capture::ProjectorPlane& plane : shots.projector_planes) {
      views.push_back({plane.board.file, printed_corners(session, plane.board, result.radiometry)});
    }
    result.camera =
        calibrate_camera(views, shots.board.square_mm, session.camera.width, session.camera.height);
    for (const std::string& sentence : check_camera_views(views, result.camera)) {
      stages.warn(sentence);
    }
  });
  stages.run("projector", 0.5, [&] {
    const auto all_planes = [&](const auto& have) {
      return std::all_of(shots.projector_planes.begin(), shots.projector_planes.end(), have);
    };
    const bool coded =
        all_planes([](const capture::ProjectorPlane& plane) { return !plane.gray_code.empty(); });
    const bool boards = all_planes(
        [](const capture::ProjectorPlane& plane) { return plane.projected.has_value(); });
    for (std::size_t p = 0; p < shots.projector_planes.size(); ++p) {
      planes.push_back({"", views[shots.camera_boards.size() + p].corners, {}});
      if (!boards) continue;
      planes[p].name = shots.projector_planes[p].projected->file;
      planes[p].projected = find_projected_chessboard(
          load_linear(session, *shots.projector_planes[p].projected, result.radiometry),
          shots.projected_board->columns, shots.projected_board->rows, planes[p].printed,
          planes[p].name);
    }
    for (const std::string& sentence : check_planes(planes)) stages.warn(sentence);
    const capture::ProjectedBoard shown =
        coded ? gray_code_lattice(session.projector) : *shots.projected_board;
    const std::vector<PlaneView> seen =
        coded ? read_gray_codes(session, shown, planes, result) : planes;
    result.projector = calibrate_projector(result.camera.lens, shots.board, shown, seen,
                                           session.projector.width, session.projector.height);
    joint = adjust_jointly({views, shots.board, shown, seen}, result.camera, result.projector);
    if (agrees(joint, result.camera)) {
      result.camera = joint.camera;
      result.projector = joint.projector;
    } else {
      stages.warn(
          "the projected corners contradict the printed boards, whose residual would rise "
          "from " +
          rounded(result.camera.rms_px, "%.3f") + " to " + rounded(joint.camera.rms_px, "%.3f") +
          " px: camera and projector are calibrated one after the other; check that the "
          "planes are flat beyond the printed board and did not move between their "
          "pictures.");
    }
    if (coded && boards) {
      result.gray_code_check_px =
          projected_board_rms(result.camera.lens, result.projector, *shots.projected_board, planes);
    }
  });
  constexpr double suspicious_rms_px = 1.0;
  if (result.camera.rms_px > suspicious_rms_px) {
    stages.warn("the camera's reprojection error is " + rounded(result.camera.rms_px) +
                " px: look for a bent board or a blurred picture among the views with the largest "
                "error in calibration.json.");
  }
  if (result.gray_code_check_px.value_or(0.0) > suspicious_rms_px) {
    stages.warn("the projected chessboards lie " + rounded(*result.gray_code_check_px) +
                " px (of the projector) from where the Gray codes put them: check projected_board "
                "in session.json and that no plane moved between its pictures.");
  }
  if (result.projector.rms_px > suspicious_rms_px) {
    stages.warn("the projector's reprojection error is " + rounded(result.projector.rms_px) +
                " px: check projected_board in session.json and that no plane moved between its "
                "pictures.");
  }
  return joint;
}

/// Light scale, flat field, the projector's black and response, room light. Returns the target
/// under full white and the room's light.
capture::HdrImage calibrate_white(const capture::Session& session,
                                  const capture::MergeOptions& merge, Stages& stages,
                                  CalibrationResult& result, std::vector<std::string>& notes) {
  const capture::WhiteTarget& target = *session.calibration.white_target;
  const std::string name =
      (session.folder / "session.json").string() + ": calibration.white_target";
  const auto picture = [&](const capture::Stack& frames, const std::string& label, bool lit) {
    capture::MergeOptions options = merge;
    options.require_light = lit;
    return capture::merge_stack(session, frames, label, result.radiometry, options, &notes);
  };
  capture::HdrImage white = picture(target.frames, "white target", true);
  capture::HdrImage projected = white;
  std::optional<capture::HdrImage> black;
  if (session.calibration.white_target_black.empty()) {
    stages.warn(
        "no white_target.black_frames: light from the projector's black pixels is taken as zero.");
  } else {
    black = picture(session.calibration.white_target_black, "white target under black", false);
  }
  std::optional<capture::HdrImage> off;
  if (!target.off_frames.empty()) {
    off = picture(target.off_frames, "white target, projector off", false);
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
  for (const capture::ProjectorLevel& level : target.levels) {
    values.push_back(level.value);
    signals.push_back(
        signal(picture(level.frames, "white target under " + std::to_string(level.value), false)));
    for (std::size_t c = 0; c < room.size(); ++c) signals.back()[c] -= room[c];
  }
  values.push_back(255);
  signals.push_back(full);
  result.projector_curve = curve_from_signals(values, signals);
  constexpr double suspicious = 0.01;
  if (result.projector_curve->channel_spread() > suspicious) {
    stages.warn("the projector's channels answer to pixel values differently, by up to " +
                rounded(100.0 * result.projector_curve->channel_spread(), "%.1f") +
                " % of white: patterns of values between black and white have their mean for "
                "light.");
  }
  return white;
}

void calibrate_light(const capture::Session& session, const capture::MergeOptions& merge,
                     Stages& stages, CalibrationResult& result) {
  std::vector<std::string> notes;
  const capture::Calibration& shots = session.calibration;
  const std::string json = (session.folder / "session.json").string();
  std::optional<capture::HdrImage> white;
  const double reflectance = shots.white_target ? shots.white_target->reflectance : 1.0;
  if (shots.white_target) white = calibrate_white(session, merge, stages, result, notes);
  if (shots.colour_chart) {
    const std::string name = json + ": calibration.colour_chart";
    const capture::HdrImage chart = capture::merge_stack(
        session, shots.colour_chart->frames, "colour chart", result.radiometry, merge, &notes);
    ChartPatches patches;
    if (const auto& given = shots.colour_chart->corners_px) {
      std::array<Eigen::Vector2d, 4> corners;
      for (std::size_t k = 0; k < 4; ++k) corners[k] = {(*given)[k][0], (*given)[k][1]};
      patches = chart_from_corners(corners);
    } else {
      patches = find_chart(to_grey(chart.radiance), name);
    }
    result.chart =
        measure_chart(chart, patches, white ? &*white : nullptr, reflectance, result.white.scale);
    if (!white) {
      if (result.chart->scale.empty()) {
        throw InputError(name + ": no neutral patch can be used; add shorter exposures");
      }
      result.scale = result.chart->scale;
      stages.warn(
          "no white target: the scale comes from the colour chart's neutral patches, and "
          "the projector's light is taken as even over the lit face.");
    } else {
      constexpr double suspicious = 0.03;
      if (result.chart->residual_rms > suspicious) {
        stages.warn("white target and colour chart disagree by " +
                    rounded(100.0 * result.chart->residual_rms, "%.1f") +
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
                      Progress& progress, const capture::HdrOptions& hdr) {
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
  stages.run("light", 0.8, [&] { calibrate_light(session, hdr.merge, stages, result); });
}

CalibrationResult calibrate(const capture::Session& session, Progress& progress,
                            const capture::HdrOptions& hdr) {
  CalibrationResult result;
  Stages stages(result, progress);
  stages.run("response", 0.0, [&] {
    result.radiometry = capture::find_radiometry(session, progress, hdr.response);
  });
  const JointCalibration joint = calibrate_lenses(session, stages, result);
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

}  // namespace kappamu::calib
