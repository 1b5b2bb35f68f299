#include "calib/residual_json.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "calib/lens/lens_model.h"
#include "core/error.h"
#include "io/json_reason.h"
#include "io/json_whole.h"
#include "io/read_file.h"

// A point is [x, y], a pose its rows [r0, r1, r2, t].
template <>
struct nlohmann::adl_serializer<Eigen::Vector2d> {
  static void to_json(json& pair, const Eigen::Vector2d& point) { pair = {point.x(), point.y()}; }
  static void from_json(const json& pair, Eigen::Vector2d& point) {
    point = {pair.at(0).get<double>(), pair.at(1).get<double>()};
  }
};
template <>
struct nlohmann::adl_serializer<kappamu::Rigid> {
  static void to_json(json& rows, const kappamu::Rigid& pose) {
    rows = json::array();
    for (int r = 0; r < 3; ++r) {
      const auto& m = pose.rotation;
      rows.push_back({m(r, 0), m(r, 1), m(r, 2), pose.translation[r]});
    }
  }
  static void from_json(const json& rows, kappamu::Rigid& pose) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) pose.rotation(r, c) = rows.at(r).at(c).get<double>();
      pose.translation[r] = rows.at(r).at(3).get<double>();
    }
  }
};

namespace kappamu::calib {

using nlohmann::json;

static void to_json(json& object, LensModel model) {
  object = to_string(model);
}
static void from_json(const json& object, LensModel& model) {
  model = lens_model_from_string(object.get<std::string>(), "calibration.json");
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ModelScore, model, bent, held_out_rms_px, chosen)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ViewResidual, name, rms_px, pixels, residuals, left_out)

static void to_json(json& object, const ProjectionUncertainty& uncertainty) {
  object = {{"distance_mm", uncertainty.distance_mm},
            {"columns", uncertainty.columns},
            {"rows", uncertainty.rows},
            {"deviation_px", uncertainty.deviation_px}};
}
static void from_json(const json& object, ProjectionUncertainty& uncertainty) {
  object.at("distance_mm").get_to(uncertainty.distance_mm);
  uncertainty.columns = io::whole<int>(object.at("columns"));
  uncertainty.rows = io::whole<int>(object.at("rows"));
  object.at("deviation_px").get_to(uncertainty.deviation_px);
}

static void to_json(json& object, const NeutralPatch& neutral) {
  object = {
      {"patch", neutral.patch}, {"published", neutral.published}, {"measured", neutral.measured}};
}
static void from_json(const json& object, NeutralPatch& neutral) {
  neutral.patch = io::whole<int>(object.at("patch"));
  object.at("published").get_to(neutral.published);
  object.at("measured").get_to(neutral.measured);
}

static void to_json(json& object, const GrayCodeView& view) {
  json quality = json::array();  // in hundredths
  for (const float value : view.quality.values()) quality.push_back(std::lround(100.0F * value));
  object = {{"name", view.name},
            {"legible_share", view.legible_share},
            {"points", view.points},
            {"width", view.quality.width()},
            {"height", view.quality.height()},
            {"quality", std::move(quality)}};
}
static void from_json(const json& object, GrayCodeView& view) {
  object.at("name").get_to(view.name);
  object.at("legible_share").get_to(view.legible_share);
  view.points = io::whole<int>(object.at("points"));
  const json& quality = object.at("quality");
  const int width = io::whole<std::uint16_t>(object.at("width"));
  const int height = io::whole<std::uint16_t>(object.at("height"));
  if (std::cmp_not_equal(quality.size(), std::int64_t{width} * height)) {
    throw json::other_error::create(501, "quality must have width times height values", &object);
  }
  view.quality = Image<float>(width, height, 1);
  for (std::size_t k = 0; k < view.quality.size(); ++k) {
    view.quality.values()[k] = 0.01F * quality.at(k).get<float>();
  }
}

static void to_json(json& object, const SamplePose& pose) {
  object = {{"station", pose.station},
            {"face", to_string(pose.face)},
            {"rms_px", pose.rms_px},
            {"corners_px", pose.corners_px},
            {"edge_px", pose.edge_px}};
}

static void to_json(json& object, const ChartReference& chart) {
  object = {{"residual_rms", chart.residual_rms},
            {"scale", chart.scale},
            {"centres", chart.patches.centres},
            {"middles", chart.patches.middles},
            {"neutrals", chart.neutrals}};
}
static void from_json(const json& object, ChartReference& chart) {
  object.at("residual_rms").get_to(chart.residual_rms);
  object.at("scale").get_to(chart.scale);
  object.at("centres").get_to(chart.patches.centres);
  object.at("middles").get_to(chart.patches.middles);
  object.at("neutrals").get_to(chart.neutrals);
}

namespace {

json views_json(const std::vector<ViewResidual>& views, const std::vector<Rigid>& poses) {
  json list = views;
  for (std::size_t v = 0; v < views.size(); ++v) list[v]["board_pose"] = poses[v];
  return list;
}

void views_from(const json& list, std::vector<ViewResidual>& views, std::vector<Rigid>& poses) {
  list.get_to(views);
  for (const json& item : list) poses.push_back(item.at("board_pose").get<Rigid>());
}

template <class T>
json json_or_null(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}

template <class T>
void get_unless_null(const json& object, std::optional<T>& value) {
  if (!object.is_null()) value = object.get<T>();
}

}  // namespace

std::string residuals_to_json(const CalibrationResult& calibration) {
  const CameraCalibration& camera = calibration.camera;
  const ProjectorCalibration& projector = calibration.projector;
  json object = {{"format", "kappamu-calibration"},
                 {"version", 1},
                 {"camera",
                  {{"rms_px", camera.rms_px},
                   {"model", camera.model},
                   {"models_tried", camera.scores},
                   {"uncertainty", calibration.camera_uncertainty},
                   {"views", views_json(camera.views, camera.camera_from_board)}}},
                 {"projector", nullptr},
                 {"gray_code",
                  {{"planes", calibration.gray_code},
                   {"check_px", json_or_null(calibration.gray_code_check_px)}}},
                 {"poses", nullptr},
                 {"light", nullptr},
                 {"chart", json_or_null(calibration.chart)},
                 {"warnings", calibration.warnings},
                 {"seconds", calibration.seconds}};
  if (!projector.views.empty()) {
    object["projector"] = {{"rms_px", projector.rms_px},
                           {"printed_rms_px", projector.printed_rms_px},
                           {"face_deviation_px", calibration.projector_deviation_px},
                           {"model", projector.model},
                           {"views", views_json(projector.views, projector.station_from_plane)}};
  }
  if (!calibration.pattern_pose.station.empty()) {
    object["poses"] = {{"calibration", calibration.calibration_pose},
                       {"pattern", calibration.pattern_pose}};
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
    camera.at("models_tried").get_to(calibration.camera.scores);
    camera.at("uncertainty").get_to(calibration.camera_uncertainty);
    views_from(camera.at("views"), calibration.camera.views, calibration.camera.camera_from_board);
    if (const json& projector = object.at("projector"); !projector.is_null()) {
      views_from(projector.at("views"), calibration.projector.views,
                 calibration.projector.station_from_plane);
      projector.at("face_deviation_px").get_to(calibration.projector_deviation_px);
    }
    object.at("gray_code").at("planes").get_to(calibration.gray_code);
    get_unless_null(object.at("gray_code").at("check_px"), calibration.gray_code_check_px);
    if (const json& poses = object.at("poses"); !poses.is_null()) {
      poses.at("calibration").at("edge_px").get_to(calibration.calibration_pose.edge_px);
      poses.at("pattern").at("edge_px").get_to(calibration.pattern_pose.edge_px);
    }
    get_unless_null(object.at("chart"), calibration.chart);
    object.at("warnings").get_to(calibration.warnings);
    object.at("seconds").get_to(calibration.seconds);
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": " + io::json_reason(error) +
                     "; calibrate the session again");
  }
}

}  // namespace kappamu::calib
