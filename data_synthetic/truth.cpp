#include "data_synthetic/truth.h"

#include <nlohmann/json.hpp>

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

Json to_json(const calib::Lens& lens) {
  return {{"width", lens.width},
          {"height", lens.height},
          {"fx", lens.fx},
          {"fy", lens.fy},
          {"cx", lens.cx},
          {"cy", lens.cy},
          {"distortion", lens.distortion}};
}
calib::Lens lens_from(const Json& json) {
  calib::Lens lens;
  json.at("width").get_to(lens.width);
  json.at("height").get_to(lens.height);
  json.at("fx").get_to(lens.fx);
  json.at("fy").get_to(lens.fy);
  json.at("cx").get_to(lens.cx);
  json.at("cy").get_to(lens.cy);
  json.at("distortion").get_to(lens.distortion);
  return lens;
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
  return {{"bit_depth", sensor.bit_depth},
          {"encoding", sensor.encoding == capture::Encoding::linear ? "linear" : "response"},
          {"electrons_full_scale", sensor.electrons_full_scale},
          {"read_noise_electrons", sensor.read_noise_electrons},
          {"noise_scale", sensor.noise_scale},
          {"black_level", sensor.black_level},
          {"response_strength", sensor.response_strength},
          {"seed", sensor.seed}};
}
SensorModel sensor_from(const Json& json) {
  SensorModel sensor;
  json.at("bit_depth").get_to(sensor.bit_depth);
  sensor.encoding = json.at("encoding").get<std::string>() == "linear"
                        ? capture::Encoding::linear
                        : capture::Encoding::response;
  json.at("electrons_full_scale").get_to(sensor.electrons_full_scale);
  json.at("read_noise_electrons").get_to(sensor.read_noise_electrons);
  json.at("noise_scale").get_to(sensor.noise_scale);
  json.at("black_level").get_to(sensor.black_level);
  json.at("response_strength").get_to(sensor.response_strength);
  json.at("seed").get_to(sensor.seed);
  return sensor;
}

Json to_json(const ProjectorModel& projector) {
  return {{"lens", to_json(projector.lens)},
          {"projector_from_world", to_json(projector.projector_from_world)},
          {"black_level", projector.black_level},
          {"gamma", projector.gamma},
          {"defocus_px", projector.defocus_px},
          {"falloff", projector.falloff},
          {"intensity", projector.intensity}};
}
ProjectorModel projector_from(const Json& json) {
  ProjectorModel projector;
  projector.lens = lens_from(json.at("lens"));
  projector.projector_from_world = rigid_from(json.at("projector_from_world"));
  json.at("black_level").get_to(projector.black_level);
  json.at("gamma").get_to(projector.gamma);
  json.at("defocus_px").get_to(projector.defocus_px);
  json.at("falloff").get_to(projector.falloff);
  json.at("intensity").get_to(projector.intensity);
  return projector;
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
                  {"camera", to_json(truth.camera_lens)},
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
    truth.camera_lens = lens_from(json.at("camera"));
    truth.projector = projector_from(json.at("projector"));
    truth.world_from_sample = rigid_from(json.at("world_from_sample"));
    for (const auto& [name, pose] : json.at("world_from_camera").items()) {
      truth.world_from_camera[name] = rigid_from(pose);
    }
    json.at("calibration_station").get_to(truth.calibration_station);
    json.at("pattern_station").get_to(truth.pattern_station);
    truth.sensor = sensor_from(json.at("sensor"));
    json.at("responsivity").get_to(truth.responsivity);
    return truth;
  } catch (const Json::exception& error) {
    throw InputError(file.string() + ": " + io::json_reason(error) + "; simulate again");
  }
}

}  // namespace kappamu::synthetic
