// The calibration as the report shows it.
#include "calib/calibration_file.h"
#include "report/read/run_data.h"

namespace kappamu::report {

namespace {

LensCalibration shown(const calib::Lens& lens, double rms_px,
                      const std::vector<calib::ViewResidual>& views) {
  LensCalibration result;
  result.rms_px = rms_px;
  result.width = lens.width;
  result.height = lens.height;
  for (const calib::ViewResidual& view : views) {
    result.views.push_back(view.name);
    result.view_rms_px.push_back(view.rms_px);
    for (std::size_t i = 0; i < view.pixels.size(); ++i) {
      result.x.push_back(view.pixels[i].x());
      result.y.push_back(view.pixels[i].y());
      result.dx.push_back(view.residuals[i].x());
      result.dy.push_back(view.residuals[i].y());
    }
  }
  return result;
}

}  // namespace

std::optional<CalibrationData> read_calibration(const std::filesystem::path& run) {
  const std::filesystem::path folder = run / "calibration";
  if (!std::filesystem::exists(folder / "calibration.json")) return std::nullopt;
  const calib::CalibrationResult calibration = calib::load_calibration(folder);
  CalibrationData data;
  data.camera = shown(calibration.camera.lens, calibration.camera.rms_px, calibration.camera.views);
  data.projector =
      shown(calibration.projector.lens, calibration.projector.rms_px, calibration.projector.views);
  data.camera_model = to_string(calibration.camera.model);
  data.projector_model = to_string(calibration.projector.model);
  data.models_tried = calibration.camera.scores;
  data.bend_mm = calibration.camera.bend_mm;
  data.uncertainty = calibration.camera_uncertainty;
  data.projector_deviation_px = calibration.projector_deviation_px;
  data.gray_code = calibration.gray_code;
  data.gray_code_check_px = calibration.gray_code_check_px;
  data.poses = {calibration.calibration_pose, calibration.pattern_pose};
  data.camera_lens = calibration.camera.lens;
  data.response = calibration.radiometry.response.linear;
  data.scale = calibration.scale;
  data.white = calibration.white;
  data.projector_curve = calibration.projector_curve;
  data.chart = calibration.chart;
  data.warnings = calibration.warnings;
  return data;
}

}  // namespace kappamu::report
