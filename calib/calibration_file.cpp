#include "calib/calibration_file.h"

#include <Eigen/Core>
#include <algorithm>

#include "calib/lens/lens_model.h"
#include "calib/residual_json.h"
#include "calib/yaml_reader.h"
#include "calib/yaml_writer.h"
#include "core/error.h"
#include "io/atomic_file.h"

namespace kappamu::calib {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<double> row_major(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

void write_rigid(YamlWriter& yaml, const std::string& key, const Rigid& motion) {
  Matrix matrix(3, 4);
  matrix << motion.rotation, motion.translation;
  yaml.matrix(key, 3, 4, row_major(matrix));
}

Rigid read_rigid(const YamlReader& yaml, const std::string& key) {
  const std::vector<double> m = yaml.matrix(key, 3, 4);
  Rigid motion;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) motion.rotation(r, c) = m[4 * r + c];
    motion.translation[r] = m[4 * r + 3];
  }
  return motion;
}

template <int n>
Eigen::Matrix<double, n, n> read_square(const YamlReader& yaml, const std::string& key) {
  const std::vector<double> values = yaml.matrix(key, n, n);
  return Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>>(values.data());
}

void write_lens(YamlWriter& yaml, const Lens& lens) {
  yaml.number("image_width", lens.width);
  yaml.number("image_height", lens.height);
  yaml.matrix("camera_matrix", 3, 3, {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1});
  yaml.matrix("distortion_coefficients", 8, 1, {lens.distortion.begin(), lens.distortion.end()});
}

Lens read_lens(const YamlReader& yaml) {
  Lens lens;
  lens.width = static_cast<int>(yaml.number("image_width"));
  lens.height = static_cast<int>(yaml.number("image_height"));
  const std::vector<double> m = yaml.matrix("camera_matrix", 3, 3);
  lens.fx = m[0];
  lens.cx = m[2];
  lens.fy = m[4];
  lens.cy = m[5];
  const std::vector<double> d = yaml.matrix("distortion_coefficients", 8, 1);
  std::copy(d.begin(), d.end(), lens.distortion.begin());
  return lens;
}

void write_pose(YamlWriter& yaml, const std::string& prefix, const SamplePose& pose) {
  yaml.text(prefix + "_station", pose.station);
  yaml.text(prefix + "_face", to_string(pose.face));
  write_rigid(yaml, prefix + "_camera_from_sample", pose.camera_from_sample);
  yaml.matrix(prefix + "_covariance", 6, 6, row_major(pose.covariance));
  yaml.matrix(prefix + "_lens_covariance", 6, 6, row_major(pose.lens_covariance));
  yaml.number(prefix + "_rms_px", pose.rms_px);
  std::vector<double> corners;
  for (const Eigen::Vector2d& corner : pose.corners_px) {
    corners.push_back(corner.x());
    corners.push_back(corner.y());
  }
  yaml.matrix(prefix + "_corners_px", 4, 2, corners);
}

SamplePose read_pose(const YamlReader& yaml, const std::string& prefix) {
  SamplePose pose;
  pose.station = yaml.text(prefix + "_station");
  pose.face = face_from_string(yaml.text(prefix + "_face"));
  pose.camera_from_sample = read_rigid(yaml, prefix + "_camera_from_sample");
  pose.covariance = read_square<6>(yaml, prefix + "_covariance");
  pose.lens_covariance = read_square<6>(yaml, prefix + "_lens_covariance");
  pose.rms_px = yaml.number(prefix + "_rms_px");
  const std::vector<double> corners = yaml.matrix(prefix + "_corners_px", 4, 2);
  for (std::size_t k = 0; k < 4; ++k) pose.corners_px[k] = {corners[2 * k], corners[2 * k + 1]};
  return pose;
}

std::string camera_yaml(const CameraCalibration& camera) {
  YamlWriter yaml;
  write_lens(yaml, camera.lens);
  yaml.text("model", to_string(camera.model));
  yaml.matrix("covariance", lens_numbers, lens_numbers, row_major(camera.covariance));
  yaml.matrix("board_bend_mm", 2, 1, {camera.bend_mm.begin(), camera.bend_mm.end()});
  yaml.number("rms_px", camera.rms_px);
  yaml.number("converged", camera.converged ? 1 : 0);
  return yaml.str();
}

std::string projector_yaml(const ProjectorCalibration& projector) {
  YamlWriter yaml;
  write_lens(yaml, projector.lens);
  yaml.text("model", to_string(projector.model));
  yaml.matrix("covariance", lens_numbers, lens_numbers, row_major(projector.covariance));
  write_rigid(yaml, "projector_from_station", projector.projector_from_station);
  yaml.matrix("pose_covariance", 6, 6, row_major(projector.pose_covariance));
  yaml.number("rms_px", projector.rms_px);
  yaml.number("printed_rms_px", projector.printed_rms_px);
  yaml.number("converged", projector.converged ? 1 : 0);
  return yaml.str();
}

std::string pose_yaml(const CalibrationResult& calibration) {
  YamlWriter yaml;
  write_pose(yaml, "calibration", calibration.calibration_pose);
  write_pose(yaml, "pattern", calibration.pattern_pose);
  write_rigid(yaml, "projector_from_sample", calibration.projector_from_sample);
  return yaml.str();
}

std::string response_yaml(const capture::Radiometry& radiometry) {
  YamlWriter yaml;
  const auto channels = static_cast<int>(radiometry.black_level.size());
  yaml.number("bit_depth", radiometry.bit_depth);
  yaml.matrix("black_level", channels, 1, radiometry.black_level);
  std::vector<double> noise;
  std::vector<double> curves;
  for (const capture::Noise& n : radiometry.noise) {
    noise.insert(noise.end(),
                 {n.electrons_full_scale, n.read_noise_electrons, n.estimated ? 1.0 : 0.0});
  }
  for (const auto& curve : radiometry.response.linear) {
    curves.insert(curves.end(), curve.begin(), curve.end());
  }
  yaml.matrix("noise", channels, 3, noise);
  yaml.matrix("linear", channels, static_cast<int>(curves.size()) / channels, curves);
  std::vector<double> reports;
  for (const capture::ResponseReport& r : radiometry.reports) {
    reports.insert(reports.end(),
                   {static_cast<double>(r.samples), static_cast<double>(r.observations),
                    r.residual_rms, r.outlier_share, r.smoothness, r.lowest_code, r.highest_code,
                    static_cast<double>(r.pooled_codes)});
  }
  yaml.number("reports_count", static_cast<double>(radiometry.reports.size()));
  if (!reports.empty()) yaml.matrix("reports", static_cast<int>(reports.size()) / 8, 8, reports);
  return yaml.str();
}

std::string radiometry_yaml(const CalibrationResult& calibration) {
  YamlWriter yaml;
  const auto channels = static_cast<int>(calibration.scale.size());
  yaml.matrix("scale", channels, 1, calibration.scale);
  const auto& flat = calibration.white.flat.coefficients;
  yaml.matrix("flat_field", FlatField::terms, 1, {flat.begin(), flat.end()});
  yaml.number("projector_black", calibration.white.projector_black);
  yaml.number("black_measured", calibration.white.black_measured ? 1 : 0);
  yaml.number("room_measured", calibration.white.room_light ? 1 : 0);
  yaml.number("room_light", calibration.white.room_light.value_or(0.0));
  yaml.number("white_pixels", static_cast<double>(calibration.white.pixels));
  yaml.number("white_channels", static_cast<double>(calibration.white.scale.size()));
  if (!calibration.white.scale.empty()) {
    yaml.matrix("white_scale", channels, 1, calibration.white.scale);
    yaml.matrix("white_residual_rms", channels, 1, calibration.white.residual_rms);
  }
  const auto& curve = calibration.projector_curve;
  yaml.number("projector_values_count", curve ? static_cast<double>(curve->values.size()) : 0.0);
  if (curve) {
    const auto count = static_cast<int>(curve->values.size());
    std::vector<double> light;
    for (const auto& channel : curve->light) {
      light.insert(light.end(), channel.begin(), channel.end());
    }
    yaml.matrix("projector_values", count, 1, {curve->values.begin(), curve->values.end()});
    yaml.matrix("projector_light", channels, count, light);
  }
  return yaml.str();
}

}  // namespace

void save_calibration(const std::filesystem::path& folder, const CalibrationResult& calibration) {
  io::write_text_atomically(folder / "camera.yml", camera_yaml(calibration.camera));
  io::write_text_atomically(folder / "projector.yml", projector_yaml(calibration.projector));
  io::write_text_atomically(folder / "pose.yml", pose_yaml(calibration));
  save_response(folder, calibration.radiometry);
  io::write_text_atomically(folder / "radiometry.yml", radiometry_yaml(calibration));
  io::write_text_atomically(folder / "calibration.json", residuals_to_json(calibration));
}

void save_lenses(const std::filesystem::path& folder, const CalibrationResult& calibration) {
  io::write_text_atomically(folder / "camera.yml", camera_yaml(calibration.camera));
  if (!calibration.projector.views.empty()) {
    io::write_text_atomically(folder / "projector.yml", projector_yaml(calibration.projector));
  }
  io::write_text_atomically(folder / "calibration.json", residuals_to_json(calibration));
}

void save_response(const std::filesystem::path& folder, const capture::Radiometry& radiometry) {
  io::write_text_atomically(folder / "response.yml", response_yaml(radiometry));
}

CalibrationResult load_calibration(const std::filesystem::path& folder) {
  CalibrationResult result;
  {
    const YamlReader yaml(folder / "camera.yml");
    result.camera.lens = read_lens(yaml);
    result.camera.model =
        lens_model_from_string(yaml.text("model"), (folder / "camera.yml").string());
    result.camera.covariance = read_square<lens_numbers>(yaml, "covariance");
    const std::vector<double> bend = yaml.matrix("board_bend_mm", 2, 1);
    std::copy(bend.begin(), bend.end(), result.camera.bend_mm.begin());
    result.camera.rms_px = yaml.number("rms_px");
    result.camera.converged = yaml.number("converged") != 0.0;
  }
  {
    const YamlReader yaml(folder / "projector.yml");
    result.projector.lens = read_lens(yaml);
    result.projector.model =
        lens_model_from_string(yaml.text("model"), (folder / "projector.yml").string());
    result.projector.covariance = read_square<lens_numbers>(yaml, "covariance");
    result.projector.projector_from_station = read_rigid(yaml, "projector_from_station");
    result.projector.pose_covariance = read_square<6>(yaml, "pose_covariance");
    result.projector.rms_px = yaml.number("rms_px");
    result.projector.printed_rms_px = yaml.number("printed_rms_px");
    result.projector.converged = yaml.number("converged") != 0.0;
  }
  {
    const YamlReader yaml(folder / "pose.yml");
    result.calibration_pose = read_pose(yaml, "calibration");
    result.pattern_pose = read_pose(yaml, "pattern");
    result.projector_from_sample = read_rigid(yaml, "projector_from_sample");
  }
  {
    const YamlReader yaml(folder / "response.yml");
    result.radiometry.bit_depth = static_cast<int>(yaml.number("bit_depth"));
    result.radiometry.black_level = yaml.column("black_level");
    const int channels = static_cast<int>(result.radiometry.black_level.size());
    const std::vector<double> noise = yaml.matrix("noise", channels, 3);
    const int codes = 1 << result.radiometry.bit_depth;
    const std::vector<double> curves = yaml.matrix("linear", channels, codes);
    for (int c = 0; c < channels; ++c) {
      const std::size_t at = std::size_t{3} * c;
      result.radiometry.noise.push_back({noise[at], noise[at + 1], noise[at + 2] != 0.0});
      const auto first = curves.begin() + static_cast<std::ptrdiff_t>(c) * codes;
      result.radiometry.response.linear.emplace_back(first, first + codes);
    }
    const int reports = static_cast<int>(yaml.number("reports_count"));
    const std::vector<double> r =
        reports > 0 ? yaml.matrix("reports", reports, 8) : std::vector<double>{};
    for (std::size_t k = 0; k < r.size(); k += 8) {
      result.radiometry.reports.push_back({static_cast<int>(r[k]), static_cast<int>(r[k + 1]),
                                           r[k + 2], r[k + 3], r[k + 4], r[k + 5], r[k + 6],
                                           static_cast<int>(r[k + 7])});
    }
  }
  {
    const YamlReader yaml(folder / "radiometry.yml");
    result.scale = yaml.column("scale");
    const std::vector<double> flat = yaml.matrix("flat_field", FlatField::terms, 1);
    std::copy(flat.begin(), flat.end(), result.white.flat.coefficients.begin());
    result.white.projector_black = yaml.number("projector_black");
    result.white.black_measured = yaml.number("black_measured") != 0.0;
    if (yaml.number("room_measured") != 0.0) result.white.room_light = yaml.number("room_light");
    result.white.pixels = static_cast<std::size_t>(yaml.number("white_pixels"));
    if (yaml.number("white_channels") > 0.0) {
      result.white.scale = yaml.column("white_scale");
      result.white.residual_rms = yaml.column("white_residual_rms");
    }
    if (const auto count = static_cast<int>(yaml.number("projector_values_count")); count > 0) {
      const std::vector<double> values = yaml.column("projector_values");
      const auto channels = static_cast<int>(result.scale.size());
      const std::vector<double> light = yaml.matrix("projector_light", channels, count);
      ProjectorCurve curve{{values.begin(), values.end()}, {}};
      for (auto first = light.begin(); first != light.end(); first += count) {
        curve.light.emplace_back(first, first + count);
      }
      result.projector_curve = std::move(curve);
    }
  }
  residuals_from_json(folder / "calibration.json", result);
  return result;
}

}  // namespace kappamu::calib
