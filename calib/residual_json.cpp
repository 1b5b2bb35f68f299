#include "calib/residual_json.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "calib/lens/lens_model.h"
#include "core/error.h"
#include "io/json_reason.h"
#include "io/read_file.h"

namespace kappamu::calib {
namespace {

using nlohmann::json;

template <class Points>
json points_json(const Points& points) {
  json list = json::array();
  for (const Eigen::Vector2d& point : points) list.push_back({point.x(), point.y()});
  return list;
}

Eigen::Vector2d point_from(const json& pair) {
  return {pair.at(0).get<double>(), pair.at(1).get<double>()};
}

std::vector<Eigen::Vector2d> points_from(const json& list) {
  std::vector<Eigen::Vector2d> points;
  for (const json& pair : list) points.push_back(point_from(pair));
  return points;
}

json views_json(const std::vector<ViewResidual>& views, const std::vector<Rigid>& poses) {
  json list = json::array();
  for (std::size_t v = 0; v < views.size(); ++v) {
    json pose = json::array();
    for (int r = 0; r < 3; ++r) {
      const auto& m = poses[v].rotation;
      pose.push_back({m(r, 0), m(r, 1), m(r, 2), poses[v].translation[r]});
    }
    list.push_back({{"name", views[v].name},
                    {"rms_px", views[v].rms_px},
                    {"pixels", points_json(views[v].pixels)},
                    {"residuals", points_json(views[v].residuals)},
                    {"left_out", views[v].left_out},
                    {"board_pose", pose}});
  }
  return list;
}

void views_from(const json& list, std::vector<ViewResidual>& views, std::vector<Rigid>& poses) {
  for (const json& item : list) {
    views.push_back({item.at("name").get<std::string>(), item.at("rms_px").get<double>(),
                     points_from(item.at("pixels")), points_from(item.at("residuals")),
                     item.at("left_out").get<std::vector<int>>()});
    Rigid pose;
    for (int r = 0; r < 3; ++r) {
      const json& row = item.at("board_pose").at(r);
      for (int c = 0; c < 3; ++c) pose.rotation(r, c) = row.at(c).get<double>();
      pose.translation[r] = row.at(3).get<double>();
    }
    poses.push_back(pose);
  }
}

json scores_json(const std::vector<ModelScore>& scores) {
  json list = json::array();
  for (const ModelScore& score : scores) {
    list.push_back({{"model", to_string(score.model)},
                    {"bent", score.bent},
                    {"held_out_rms_px", score.held_out_rms_px},
                    {"chosen", score.chosen}});
  }
  return list;
}

std::vector<ModelScore> scores_from(const json& list, const std::filesystem::path& file) {
  std::vector<ModelScore> scores;
  for (const json& item : list) {
    scores.push_back({lens_model_from_string(item.at("model").get<std::string>(), file.string()),
                      item.at("bent").get<bool>(), item.at("held_out_rms_px").get<double>(),
                      item.at("chosen").get<bool>()});
  }
  return scores;
}

json uncertainty_json(const ProjectionUncertainty& uncertainty) {
  return {{"distance_mm", uncertainty.distance_mm},
          {"columns", uncertainty.columns},
          {"rows", uncertainty.rows},
          {"deviation_px", uncertainty.deviation_px}};
}

ProjectionUncertainty uncertainty_from(const json& object) {
  return {object.at("distance_mm").get<double>(), object.at("columns").get<int>(),
          object.at("rows").get<int>(), object.at("deviation_px").get<std::vector<double>>()};
}

json gray_codes_json(const CalibrationResult& calibration) {
  json list = json::array();
  for (const GrayCodeView& view : calibration.gray_code) {
    json quality = json::array();  // in hundredths
    for (const float value : view.quality.values()) quality.push_back(std::lround(100.0F * value));
    list.push_back({{"name", view.name},
                    {"legible_share", view.legible_share},
                    {"points", view.points},
                    {"width", view.quality.width()},
                    {"height", view.quality.height()},
                    {"quality", std::move(quality)}});
  }
  return {{"planes", std::move(list)},
          {"check_px",
           calibration.gray_code_check_px ? json(*calibration.gray_code_check_px) : json(nullptr)}};
}

void gray_codes_from(const json& object, CalibrationResult& calibration) {
  for (const json& item : object.at("planes")) {
    Image<float> quality(item.at("width").get<int>(), item.at("height").get<int>(), 1);
    for (std::size_t k = 0; k < quality.size(); ++k) {
      quality.values()[k] = 0.01F * item.at("quality").at(k).get<float>();
    }
    calibration.gray_code.push_back({item.at("name").get<std::string>(),
                                     item.at("legible_share").get<double>(),
                                     item.at("points").get<int>(), std::move(quality)});
  }
  if (!object.at("check_px").is_null()) {
    calibration.gray_code_check_px = object.at("check_px").get<double>();
  }
}

json pose_json(const SamplePose& pose) {
  return {{"station", pose.station},
          {"face", to_string(pose.face)},
          {"rms_px", pose.rms_px},
          {"corners_px", points_json(pose.corners_px)},
          {"edge_px", points_json(pose.edge_px)}};
}

json chart_json(const ChartReference& chart) {
  json neutrals = json::array();
  for (const NeutralPatch& neutral : chart.neutrals) {
    neutrals.push_back({{"patch", neutral.patch},
                        {"published", neutral.published},
                        {"measured", neutral.measured}});
  }
  json middles = json::array();
  for (const auto& middle : chart.patches.middles) middles.push_back(points_json(middle));
  return {{"residual_rms", chart.residual_rms},
          {"scale", chart.scale},
          {"centres", points_json(chart.patches.centres)},
          {"middles", middles},
          {"neutrals", neutrals}};
}

ChartReference chart_from(const json& object) {
  ChartReference chart;
  chart.residual_rms = object.at("residual_rms").get<double>();
  chart.scale = object.at("scale").get<std::vector<double>>();
  for (std::size_t p = 0; p < chart.patches.centres.size(); ++p) {
    chart.patches.centres[p] = point_from(object.at("centres").at(p));
    for (std::size_t k = 0; k < 4; ++k) {
      chart.patches.middles[p][k] = point_from(object.at("middles").at(p).at(k));
    }
  }
  for (const json& neutral : object.at("neutrals")) {
    chart.neutrals.push_back({neutral.at("patch").get<int>(), neutral.at("published").get<double>(),
                              neutral.at("measured").get<std::vector<double>>()});
  }
  return chart;
}

}  // namespace

std::string residuals_to_json(const CalibrationResult& calibration) {
  const CameraCalibration& camera = calibration.camera;
  const ProjectorCalibration& projector = calibration.projector;
  json object = {{"format", "kappamu-calibration"},
                 {"version", 1},
                 {"camera",
                  {{"rms_px", camera.rms_px},
                   {"model", to_string(camera.model)},
                   {"models_tried", scores_json(camera.scores)},
                   {"uncertainty", uncertainty_json(calibration.camera_uncertainty)},
                   {"views", views_json(camera.views, camera.camera_from_board)}}},
                 {"projector", nullptr},
                 {"gray_code", gray_codes_json(calibration)},
                 {"poses", nullptr},
                 {"light", nullptr},
                 {"chart", calibration.chart ? chart_json(*calibration.chart) : json(nullptr)},
                 {"warnings", calibration.warnings},
                 {"seconds", calibration.seconds}};
  if (!projector.views.empty()) {
    object["projector"] = {{"rms_px", projector.rms_px},
                           {"printed_rms_px", projector.printed_rms_px},
                           {"face_deviation_px", calibration.projector_deviation_px},
                           {"model", to_string(projector.model)},
                           {"views", views_json(projector.views, projector.station_from_plane)}};
  }
  if (!calibration.pattern_pose.station.empty()) {
    object["poses"] = {{"calibration", pose_json(calibration.calibration_pose)},
                       {"pattern", pose_json(calibration.pattern_pose)}};
  }
  if (!calibration.scale.empty()) {
    object["light"] = {{"scale", calibration.scale},
                       {"white_residual_rms", calibration.white.residual_rms},
                       {"projector_black", calibration.white.projector_black}};
  }
  return object.dump(1) + "\n";
}

void residuals_from_json(const std::filesystem::path& file, CalibrationResult& calibration) {
  if (!std::filesystem::exists(file)) {
    throw InputError(file.string() + ": the file is missing; calibrate the session again");
  }
  try {
    const json object = json::parse(io::read_text(file));
    const json& camera = object.at("camera");
    calibration.camera.scores = scores_from(camera.at("models_tried"), file);
    calibration.camera_uncertainty = uncertainty_from(camera.at("uncertainty"));
    views_from(camera.at("views"), calibration.camera.views, calibration.camera.camera_from_board);
    if (const json& projector = object.at("projector"); !projector.is_null()) {
      views_from(projector.at("views"), calibration.projector.views,
                 calibration.projector.station_from_plane);
      calibration.projector_deviation_px = projector.at("face_deviation_px").get<double>();
    }
    gray_codes_from(object.at("gray_code"), calibration);
    if (const json& poses = object.at("poses"); !poses.is_null()) {
      calibration.calibration_pose.edge_px = points_from(poses.at("calibration").at("edge_px"));
      calibration.pattern_pose.edge_px = points_from(poses.at("pattern").at("edge_px"));
    }
    if (!object.at("chart").is_null()) calibration.chart = chart_from(object.at("chart"));
    calibration.warnings = object.at("warnings").get<std::vector<std::string>>();
    calibration.seconds = object.at("seconds").get<std::map<std::string, double>>();
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": " + io::json_reason(error) +
                     "; calibrate the session again");
  }
}

}  // namespace kappamu::calib
