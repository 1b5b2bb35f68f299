#include "calib/calibration_file.h"

#include <Eigen/Core>
#include <algorithm>
#include <tuple>

#include "calib/lens/lens_model.h"
#include "calib/opencv_yaml.h"
#include "calib/residual_json.h"
#include "core/error.h"
#include "io/atomic_file.h"

namespace kappamu::calib {
namespace {

// Yaml is YamlWriter or YamlReader (opencv_yaml.h).

/// An int, std::size_t or bool (0 or 1); from low to high, where they are given.
template <class Yaml, class Number, class... Limits>
void whole_number(Yaml& yaml, const std::string& key, Number& value, Limits... limits) {
  auto number = static_cast<double>(value);
  yaml.number(key, number);
  value = yaml.template number_as<Number>(key, number, limits...);
}

template <class Yaml, int rows, int columns>
void fixed_matrix(Yaml& yaml, const std::string& key,
                  Eigen::Matrix<double, rows, columns>& matrix) {
  using RowMajor = Eigen::Matrix<double, rows, columns, Eigen::RowMajor>;
  const RowMajor ordered = matrix;
  std::vector<double> values(ordered.data(), ordered.data() + ordered.size());
  yaml.matrix(key, rows, columns, values);
  matrix = Eigen::Map<const RowMajor>(values.data());
}

template <class Yaml, std::size_t n>
void fixed_column(Yaml& yaml, const std::string& key, std::array<double, n>& numbers) {
  std::vector<double> values(numbers.begin(), numbers.end());
  yaml.matrix(key, static_cast<int>(n), 1, values);
  std::copy(values.begin(), values.end(), numbers.begin());
}

/// Rows of equal length.
template <class Yaml>
void table(Yaml& yaml, const std::string& key, int rows, int columns,
           std::vector<std::vector<double>>& lists) {
  std::vector<double> values;
  for (const std::vector<double>& list : lists) {
    values.insert(values.end(), list.begin(), list.end());
  }
  yaml.matrix(key, rows, columns, values);
  lists.clear();
  for (auto first = values.begin(); first != values.end(); first += columns) {
    lists.emplace_back(first, first + columns);
  }
}

/// A row for each item, of its `members`, numbers of any type.
template <class Yaml, class Item, class... Member>
void item_table(Yaml& yaml, const std::string& key, int rows, std::vector<Item>& items,
                Member Item::*... members) {
  std::vector<double> values;
  for (const Item& item : items) (values.push_back(static_cast<double>(item.*members)), ...);
  yaml.matrix(key, rows, static_cast<int>(sizeof...(members)), values);
  items.resize(static_cast<std::size_t>(rows));
  auto value = values.begin();
  for (Item& item : items) ((item.*members = yaml.template number_as<Member>(key, *value++)), ...);
}

template <class Yaml>
void transfer(Yaml& yaml, const std::string& key, Rigid& motion) {
  Eigen::Matrix<double, 3, 4> matrix;
  matrix << motion.rotation, motion.translation;
  fixed_matrix(yaml, key, matrix);
  motion = {matrix.leftCols<3>(), matrix.col(3)};
}

template <class Yaml>
void transfer(Yaml& yaml, Lens& lens) {
  whole_number(yaml, "image_width", lens.width);
  whole_number(yaml, "image_height", lens.height);
  Eigen::Matrix3d camera{{lens.fx, 0, lens.cx}, {0, lens.fy, lens.cy}, {0, 0, 1}};
  fixed_matrix(yaml, "camera_matrix", camera);
  std::tie(lens.fx, lens.cx, lens.fy, lens.cy) =
      std::tuple(camera(0, 0), camera(0, 2), camera(1, 1), camera(1, 2));
  fixed_column(yaml, "distortion_coefficients", lens.distortion);
}

/// What camera and projector have in common.
template <class Yaml, class Calibration>
void transfer_lens(Yaml& yaml, Calibration& calibration, const std::string& file) {
  transfer(yaml, calibration.lens);
  std::string model = to_string(calibration.model);
  yaml.text("model", model);
  calibration.model = lens_model_from_string(model, file);
  fixed_matrix(yaml, "covariance", calibration.covariance);
}

template <class Yaml>
void transfer(Yaml& yaml, CameraCalibration& camera, const std::string& file) {
  transfer_lens(yaml, camera, file);
  fixed_column(yaml, "board_bend_mm", camera.bend_mm);
  yaml.number("rms_px", camera.rms_px);
  whole_number(yaml, "converged", camera.converged);
}

template <class Yaml>
void transfer(Yaml& yaml, ProjectorCalibration& projector, const std::string& file) {
  transfer_lens(yaml, projector, file);
  transfer(yaml, "projector_from_station", projector.projector_from_station);
  fixed_matrix(yaml, "pose_covariance", projector.pose_covariance);
  yaml.number("rms_px", projector.rms_px);
  yaml.number("printed_rms_px", projector.printed_rms_px);
  whole_number(yaml, "converged", projector.converged);
}

template <class Yaml>
void transfer(Yaml& yaml, const std::string& prefix, SamplePose& pose) {
  yaml.text(prefix + "_station", pose.station);
  std::string face = to_string(pose.face);
  yaml.text(prefix + "_face", face);
  pose.face = face_from_string(face);
  transfer(yaml, prefix + "_camera_from_sample", pose.camera_from_sample);
  fixed_matrix(yaml, prefix + "_covariance", pose.covariance);
  fixed_matrix(yaml, prefix + "_lens_covariance", pose.lens_covariance);
  yaml.number(prefix + "_rms_px", pose.rms_px);
  Eigen::Matrix<double, 4, 2> corners;
  for (int k = 0; k < 4; ++k) corners.row(k) = pose.corners_px[k].transpose();
  fixed_matrix(yaml, prefix + "_corners_px", corners);
  for (int k = 0; k < 4; ++k) pose.corners_px[k] = corners.row(k).transpose();
}

template <class Yaml>
void transfer_poses(Yaml& yaml, CalibrationResult& calibration) {
  transfer(yaml, "calibration", calibration.calibration_pose);
  transfer(yaml, "pattern", calibration.pattern_pose);
  transfer(yaml, "projector_from_sample", calibration.projector_from_sample);
}

template <class Yaml>
void transfer(Yaml& yaml, capture::Radiometry& radiometry) {
  using capture::Noise;
  using Report = capture::ResponseReport;
  whole_number(yaml, "bit_depth", radiometry.bit_depth, 1, 16);
  yaml.column("black_level", radiometry.black_level);
  const auto channels = static_cast<int>(radiometry.black_level.size());
  item_table(yaml, "noise", channels, radiometry.noise, &Noise::electrons_full_scale,
             &Noise::read_noise_electrons, &Noise::estimated);
  table(yaml, "linear", channels, 1 << radiometry.bit_depth, radiometry.response.linear);
  auto reports = static_cast<int>(radiometry.reports.size());
  whole_number(yaml, "reports_count", reports);
  if (reports <= 0) return;
  item_table(yaml, "reports", reports, radiometry.reports, &Report::samples, &Report::observations,
             &Report::residual_rms, &Report::outlier_share, &Report::smoothness,
             &Report::lowest_code, &Report::highest_code, &Report::pooled_codes);
}

template <class Yaml>
void transfer(Yaml& yaml, std::optional<ProjectorCurve>& measured, int channels) {
  ProjectorCurve curve = measured.value_or(ProjectorCurve{});
  auto count = static_cast<int>(curve.values.size());
  whole_number(yaml, "projector_values_count", count);
  if (count <= 0) return;
  std::vector<double> values(curve.values.begin(), curve.values.end());
  yaml.column("projector_values", values);
  curve.values.clear();
  for (const double value : values) {
    curve.values.push_back(yaml.template number_as<int>("projector_values", value, 0, 255));
  }
  table(yaml, "projector_light", channels, count, curve.light);
  measured = std::move(curve);
}

/// Absent where there is none, as in files of before the number was known.
void optional_number(YamlWriter& yaml, const std::string& key, std::optional<double>& value) {
  if (value) yaml.number(key, *value);
}
void optional_number(YamlReader& yaml, const std::string& key, std::optional<double>& value) {
  double number = -1.0;
  if (yaml.has(key)) yaml.number(key, number);
  value = number < 0.0 ? std::nullopt : std::optional(number);
}

template <class Yaml>
void transfer_light(Yaml& yaml, CalibrationResult& calibration) {
  WhiteReference& white = calibration.white;
  yaml.column("scale", calibration.scale);
  fixed_column(yaml, "flat_field", white.flat.coefficients);
  yaml.number("projector_black", white.projector_black);
  whole_number(yaml, "black_measured", white.black_measured);
  bool room_measured = white.room_light.has_value();
  double room_light = white.room_light.value_or(0.0);
  whole_number(yaml, "room_measured", room_measured);
  yaml.number("room_light", room_light);
  if (room_measured) white.room_light = room_light;
  whole_number(yaml, "white_pixels", white.pixels);
  optional_number(yaml, "white_smooth_error", white.smooth_error);
  optional_number(yaml, "white_level_error", white.level_error);
  auto channels = static_cast<double>(white.scale.size());
  yaml.number("white_channels", channels);
  if (channels > 0.0) {
    yaml.column("white_scale", white.scale);
    yaml.column("white_residual_rms", white.residual_rms);
  }
  transfer(yaml, calibration.projector_curve, static_cast<int>(calibration.scale.size()));
}

/// Calls act(file's name, transfer_all(yaml, the file's name with its folder)) for each YAML file.
template <class Act>
void for_each_file(CalibrationResult& calibration, const Act& act) {
  act("camera.yml",
      [&](auto& yaml, const std::string& file) { transfer(yaml, calibration.camera, file); });
  act("projector.yml",
      [&](auto& yaml, const std::string& file) { transfer(yaml, calibration.projector, file); });
  act("pose.yml", [&](auto& yaml, const auto&) { transfer_poses(yaml, calibration); });
  act("response.yml", [&](auto& yaml, const auto&) { transfer(yaml, calibration.radiometry); });
  act("radiometry.yml", [&](auto& yaml, const auto&) { transfer_light(yaml, calibration); });
}

template <class Transfer>
void write_yaml(const std::filesystem::path& file, const Transfer& transfer_all) {
  YamlWriter yaml;
  transfer_all(yaml, file.string());
  io::write_text_atomically(file, yaml.str());
}

}  // namespace

void save_calibration(const std::filesystem::path& folder, const CalibrationResult& calibration) {
  CalibrationResult written = calibration;
  for_each_file(written, [&](const char* name, const auto& transfer_all) {
    write_yaml(folder / name, transfer_all);
  });
  io::write_text_atomically(folder / "calibration.json", residuals_to_json(calibration));
}

void save_lenses(const std::filesystem::path& folder, const CalibrationResult& calibration) {
  CalibrationResult written = calibration;
  for_each_file(written, [&](const std::string& name, const auto& transfer_all) {
    const bool projector = name == "projector.yml" && !calibration.projector.views.empty();
    if (name == "camera.yml" || projector) write_yaml(folder / name, transfer_all);
  });
  io::write_text_atomically(folder / "calibration.json", residuals_to_json(calibration));
}

void save_response(const std::filesystem::path& folder, const capture::Radiometry& radiometry) {
  capture::Radiometry written = radiometry;
  write_yaml(folder / "response.yml", [&](auto& yaml, const auto&) { transfer(yaml, written); });
}

CalibrationResult load_calibration(const std::filesystem::path& folder) {
  CalibrationResult result;
  for_each_file(result, [&](const char* name, const auto& transfer_all) {
    YamlReader yaml(folder / name);
    transfer_all(yaml, (folder / name).string());
  });
  residuals_from_json(folder / "calibration.json", result);
  return result;
}

}  // namespace kappamu::calib
