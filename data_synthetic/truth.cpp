#include "data_synthetic/truth.h"

#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/file_name.h"
#include "io/atomic_file.h"
#include "io/json_reason.h"
#include "io/read_file.h"

namespace kappamu::synthetic {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const GridShape& grid) {
  return {{"voxels", {grid.nx, grid.ny, grid.nz}}, {"voxel_mm", grid.voxel_mm}};
}
GridShape grid_from(const Json& json) {
  const auto voxels = json.at("voxels").get<std::array<int, 3>>();
  return {voxels[0], voxels[1], voxels[2], json.at("voxel_mm").get<double>()};
}

// The plain fields of a model, once for writing and reading.
constexpr auto lens_fields = std::make_tuple(
    std::pair{"width", &calib::Lens::width}, std::pair{"height", &calib::Lens::height},
    std::pair{"fx", &calib::Lens::fx}, std::pair{"fy", &calib::Lens::fy},
    std::pair{"cx", &calib::Lens::cx}, std::pair{"cy", &calib::Lens::cy},
    std::pair{"distortion", &calib::Lens::distortion});
constexpr auto sensor_fields =
    std::make_tuple(std::pair{"bit_depth", &SensorModel::bit_depth},
                    std::pair{"electrons_full_scale", &SensorModel::electrons_full_scale},
                    std::pair{"read_noise_electrons", &SensorModel::read_noise_electrons},
                    std::pair{"noise_scale", &SensorModel::noise_scale},
                    std::pair{"black_level", &SensorModel::black_level},
                    std::pair{"response_strength", &SensorModel::response_strength},
                    std::pair{"seed", &SensorModel::seed});
constexpr auto projector_fields =
    std::make_tuple(std::pair{"black_level", &ProjectorModel::black_level},
                    std::pair{"gamma", &ProjectorModel::gamma},
                    std::pair{"defocus_px", &ProjectorModel::defocus_px},
                    std::pair{"falloff", &ProjectorModel::falloff},
                    std::pair{"intensity", &ProjectorModel::intensity});

template <class Model, class Fields>
Json json_of(const Model& model, const Fields& fields) {
  Json json;
  std::apply([&](const auto&... field) { ((json[field.first] = model.*field.second), ...); },
             fields);
  return json;
}
template <class Model, class Fields>
void read_fields(const Json& json, const Fields& fields, Model& model) {
  std::apply([&](const auto&... field) { (json.at(field.first).get_to(model.*field.second), ...); },
             fields);
}

Json to_json(const Rigid& pose) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    rows.push_back({pose.rotation(r, 0), pose.rotation(r, 1), pose.rotation(r, 2)});
  }
  const Eigen::Vector3d& t = pose.translation;
  return {{"rotation", rows}, {"translation_mm", {t.x(), t.y(), t.z()}}};
}
Rigid rigid_from(const Json& json) {
  Rigid pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.rotation(r, c) = json.at("rotation").at(r).at(c).get<double>();
    pose.translation[r] = json.at("translation_mm").at(r).get<double>();
  }
  return pose;
}

Json to_json(const SensorModel& sensor) {
  Json json = json_of(sensor, sensor_fields);
  json["encoding"] = sensor.encoding == capture::Encoding::linear ? "linear" : "response";
  return json;
}

Json to_json(const ProjectorModel& projector) {
  Json json = json_of(projector, projector_fields);
  json["lens"] = json_of(projector.lens, lens_fields);
  json["projector_from_world"] = to_json(projector.projector_from_world);
  return json;
}

}  // namespace

void write_truth(const std::filesystem::path& folder, const Truth& truth) {
  Json stations;
  for (const auto& [name, pose] : truth.world_from_camera) stations[name] = to_json(pose);
  const Json json{{"format", "kappamu-truth"},
                  {"version", 1},
                  {"units", {{"length", "mm"}, {"time", "s"}}},
                  {"sample", truth.sample},
                  {"seed", truth.seed},
                  {"channels", truth.channels},
                  {"grid", to_json(truth.grid)},
                  {"transport",
                   {{"model", truth.transport_model},
                    {"grid", to_json(truth.transport_grid)},
                    {"backend", truth.transport_backend}}},
                  {"eta", truth.eta},
                  {"setup", truth.setup == capture::Setup::back_lit ? "back-lit" : "front-lit"},
                  {"lit_face", to_string(truth.lit_face)},
                  {"seen_face", to_string(truth.seen_face)},
                  {"sides", to_string(truth.sides)},
                  {"holdout", truth.holdout},
                  {"camera", json_of(truth.camera_lens, lens_fields)},
                  {"projector", to_json(truth.projector)},
                  {"world_from_sample", to_json(truth.world_from_sample)},
                  {"world_from_camera", stations},
                  {"calibration_station", truth.calibration_station},
                  {"pattern_station", truth.pattern_station},
                  {"sensor", to_json(truth.sensor)},
                  {"responsivity", truth.responsivity}};
  io::write_text_atomically(folder / "truth.json", json.dump(1) + "\n");
}

Truth read_truth(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "truth.json";
  try {
    const Json json = Json::parse(io::read_text(file));
    if (json.at("format") != "kappamu-truth" || json.at("version") != 1) {
      throw InputError(file.string() + ": not a truth file of version 1; simulate again");
    }
    Truth truth;
    json.at("sample").get_to(truth.sample);
    json.at("seed").get_to(truth.seed);
    json.at("channels").get_to(truth.channels);
    for (const std::string& channel : truth.channels) {
      require_plain_name(channel, file.string() + ": a name in channels");
    }
    truth.grid = grid_from(json.at("grid"));
    truth.transport_grid = grid_from(json.at("transport").at("grid"));
    json.at("transport").at("model").get_to(truth.transport_model);
    json.at("transport").at("backend").get_to(truth.transport_backend);
    json.at("eta").get_to(truth.eta);
    truth.setup =
        json.at("setup") == "back-lit" ? capture::Setup::back_lit : capture::Setup::front_lit;
    truth.lit_face = face_from_string(json.at("lit_face"));
    truth.seen_face = face_from_string(json.at("seen_face"));
    truth.sides = sides_from_string(json.at("sides"));
    json.at("holdout").get_to(truth.holdout);
    read_fields(json.at("camera"), lens_fields, truth.camera_lens);
    const Json& projector = json.at("projector");
    read_fields(projector, projector_fields, truth.projector);
    read_fields(projector.at("lens"), lens_fields, truth.projector.lens);
    truth.projector.projector_from_world = rigid_from(projector.at("projector_from_world"));
    truth.world_from_sample = rigid_from(json.at("world_from_sample"));
    for (const auto& [name, pose] : json.at("world_from_camera").items()) {
      truth.world_from_camera[name] = rigid_from(pose);
    }
    json.at("calibration_station").get_to(truth.calibration_station);
    json.at("pattern_station").get_to(truth.pattern_station);
    const Json& sensor = json.at("sensor");
    read_fields(sensor, sensor_fields, truth.sensor);
    truth.sensor.encoding =
        sensor.at("encoding") == "linear" ? capture::Encoding::linear : capture::Encoding::response;
    json.at("responsivity").get_to(truth.responsivity);
    return truth;
  } catch (const Json::exception& error) {
    throw InputError(file.string() + ": " + io::json_reason(error) + "; simulate again");
  }
}

}  // namespace kappamu::synthetic
