#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "calib/sample/face.h"
#include "report/drawing/chart.h"
#include "report/drawing/picture.h"
#include "report/sections.h"

namespace kappamu::report {

namespace {

/// Residuals enlarged so that a typical one (their RMS) is drawn as 3 % of the picture's width,
/// rounded to a power of ten times 1, 2 or 5.
double drawing_scale(const PointChart& points) {
  double sum = 0.0;
  for (std::size_t i = 0; i < points.dx.size(); ++i)
    sum += points.dx[i] * points.dx[i] + points.dy[i] * points.dy[i];
  const double rms = std::sqrt(sum / std::max<double>(1.0, static_cast<double>(points.dx.size())));
  if (rms <= 0.0) return 1.0;
  const double wanted = 0.03 * points.plane_width / rms;
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double digit = wanted / power;
  return power * (digit < 2.0 ? 1.0 : digit < 5.0 ? 2.0 : 5.0);
}

/// What the lens model explains of views it was not fitted to.
Html models_table(const calib::CalibrationResult& calibration) {
  std::vector<std::vector<Html>> rows;
  for (const calib::ModelScore& score : calibration.camera.scores) {
    rows.push_back({text(to_string(score.model)), text(score.bent ? "bent" : "flat"),
                    text(number(score.held_out_rms_px, 4)), text(score.chosen ? "chosen" : "")});
  }
  return table({"Lens model", "board", "RMS of views left out [px]", ""}, rows);
}

/// Standard deviation across the frame, as a map.
Html uncertainty_map(const calib::CalibrationResult& calibration) {
  const calib::ProjectionUncertainty& map = calibration.camera_uncertainty;
  Image<float> image(map.columns, map.rows, 1);
  for (std::size_t k = 0; k < image.size(); ++k) {
    image.values()[k] = static_cast<float>(map.deviation_px[k]);
  }
  const double high = quantile(image.values(), 1.0);
  constexpr int width = 420;  // CSS px
  return figure(
      picture(coloured(image, ColourMap::viridis, 0.0, high), width, "projection uncertainty") +
          legend(ColourMap::viridis, 0.0, high, "px, one standard deviation"),
      "How well the camera knows where it sees a point " + number(map.distance_mm) +
          " mm away: predicted from the boards' corners, over the frame");
}

/// How legible each plane's Gray code is, where on the picture; one scale for all.
Html gray_code_block(const calib::CalibrationResult& calibration) {
  constexpr int width = 200;  // CSS px
  double high = 0.0;
  for (const calib::GrayCodeView& view : calibration.gray_code) {
    high = std::max(high, quantile(view.quality.values(), 0.99));
  }
  std::vector<Html> maps;
  for (const calib::GrayCodeView& view : calibration.gray_code) {
    const std::string first = std::filesystem::path(view.name).filename().string();
    maps.push_back(
        figure(picture(coloured(view.quality, ColourMap::viridis, 0.0, high), width, view.name),
               first + ": " + percent(view.legible_share) + ", " + std::to_string(view.points) +
                   " points"));
  }
  Html content = row(maps) + legend(ColourMap::viridis, 0.0, high,
                                    "contrast of the weakest bit read, over white − black");
  content += note(
      "Below each plane's first picture: part of the picture where its code is legible, "
      "points of the projector's frame located by it.");
  if (calibration.gray_code_check_px) {
    content += note("The projected chessboards, which took no part, lie " +
                    number(*calibration.gray_code_check_px, 3) +
                    " projector pixels (RMS) from where the Gray codes put them.");
  }
  return subsection("Gray codes: how legible", content);
}

Html poses_table(const RunData& run) {
  std::vector<std::vector<Html>> rows;
  for (const calib::SamplePose& pose :
       {run.calibration->calibration_pose, run.calibration->pattern_pose}) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    if (run.session) {
      const auto corners = calib::face_corners(run.session->sample.shape(), pose.face);
      point = 0.5 * (corners[0] + corners[2]);
    }
    const calib::PoseUncertainty sigma = calib::pose_uncertainty(pose, point);
    rows.push_back({text(pose.station), text(to_string(pose.face)), text(number(pose.rms_px)),
                    text(number(sigma.place_mm.x(), 2) + ", " + number(sigma.place_mm.y(), 2) +
                         ", " + number(sigma.place_mm.z(), 2)),
                    text(number(sigma.turn_degrees, 2))});
  }
  return table({"Station", "face", "outline RMS [px]", "σ of place x, y, z [mm]", "σ of turn [°]"},
               rows);
}

Html sample_block(const RunData& run) {
  std::vector<Html> blocks;
  for (const SamplePicture& sample : run.sample_pictures) {
    blocks.push_back(
        figure(picture(sample.image, sample.image.width(), "sample from " + sample.station),
               "Face " + sample.face + " from station " + sample.station +
                   ": voxel edges by the calibrated pose, outline points as found"));
  }
  return poses_table(run) + row(blocks);
}

Html lens_block(const std::string& name, const calib::Lens& lens, double rms_px,
                const std::vector<calib::ViewResidual>& views) {
  BarChart bars;
  bars.y_label = "RMS [px]";
  bars.reference = rms_px;
  bars.reference_label = "all: " + number(rms_px) + " px";
  PointChart points;
  points.plane_width = lens.width;
  points.plane_height = lens.height;
  for (const calib::ViewResidual& view : views) {
    bars.labels.push_back(std::to_string(bars.labels.size()));
    bars.values.push_back(view.rms_px);
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      points.x.push_back(view.pixels[i].x());
      points.y.push_back(view.pixels[i].y());
      points.dx.push_back(view.residuals[i].x());
      points.dy.push_back(view.residuals[i].y());
    }
  }
  points.vector_scale = drawing_scale(points);
  std::vector<Html> blocks;
  if (!bars.values.empty()) blocks.push_back(figure(render(bars), "Reprojection RMS by view"));
  if (!points.x.empty()) {
    blocks.push_back(
        figure(render(points), "Where the " + std::to_string(points.x.size()) +
                                   " corners lie in the picture (" + std::to_string(lens.width) +
                                   " × " + std::to_string(lens.height) + " px), residuals drawn " +
                                   number(points.vector_scale) + " times enlarged"));
  }
  return subsection(name + ": " + number(rms_px) + " px RMS", row(blocks));
}

}  // namespace

Html calibration_section(const RunData& run) {
  Html content;
  if (!run.calibration) {
    content += note("This run has no calibration: it was fitted from ready surface measurements.");
    return section("Geometric calibration", content);
  }
  const calib::CalibrationResult& calibration = *run.calibration;
  const calib::CameraCalibration& lens = calibration.camera;
  const calib::ProjectorCalibration& projector = calibration.projector;
  content +=
      lens_block("Camera (" + to_string(lens.model) + ")", lens.lens, lens.rms_px, lens.views);
  std::vector<Html> camera;
  if (calibration.camera_uncertainty.columns > 0) camera.push_back(uncertainty_map(calibration));
  if (!lens.scores.empty()) camera.push_back(models_table(calibration));
  if (!camera.empty()) content += subsection("What the camera's calibration is worth", row(camera));
  if (lens.bend_mm != std::array<double, 2>{}) {
    content +=
        note("The printed board is bent by " + number(lens.bend_mm[0], 2) + " mm across and " +
             number(lens.bend_mm[1], 2) + " mm along its height; this was allowed for.");
  }
  content += lens_block("Projector (" + to_string(projector.model) + ")", projector.lens,
                        projector.rms_px, projector.views);
  content += note("Which projector pixel lights a corner of the lit face is known to " +
                  number(calibration.projector_deviation_px, 2) +
                  " px (one standard deviation, the worst corner's; camera, projector and planes "
                  "together).");
  if (!calibration.gray_code.empty()) content += gray_code_block(calibration);
  content += subsection("Where the sample stands", sample_block(run));
  content += note(
      "Views far above the others are worth a look; corners should reach into the corners of the "
      "picture, and residuals should point everywhere, without a common trend.");
  return section("Geometric calibration", content);
}

}  // namespace kappamu::report
