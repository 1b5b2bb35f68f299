// truth.json by one description of its fields (io/json_fields.h).
#include "data_synthetic/truth.h"

#include "core/file_name.h"
#include "io/atomic_file.h"
#include "io/json_fields.h"

namespace kappamu {

template <class Fields>
void describe(Fields& fields, GridShape& grid) {
  std::array<int, 3> voxels{grid.nx, grid.ny, grid.nz};
  fields("voxels", voxels);
  fields("voxel_mm", grid.voxel_mm);
  grid = {voxels[0], voxels[1], voxels[2], grid.voxel_mm};
}

template <class Fields>
void describe(Fields& fields, Rigid& pose) {
  std::array<std::array<double, 3>, 3> rotation{};
  std::array<double, 3> translation{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) rotation[r][c] = pose.rotation(r, c);
    translation[r] = pose.translation[r];
  }
  fields("rotation", rotation);
  fields("translation_mm", translation);
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) pose.rotation(r, c) = rotation[r][c];
    pose.translation[r] = translation[r];
  }
}

namespace calib {

template <class Fields>
void describe(Fields& fields, Lens& lens) {
  fields("width", lens.width);
  fields("height", lens.height);
  fields("fx", lens.fx);
  fields("fy", lens.fy);
  fields("cx", lens.cx);
  fields("cy", lens.cy);
  fields("distortion", lens.distortion);
}

}  // namespace calib

namespace synthetic {

template <class Fields>
void describe(Fields& fields, ProjectorModel& projector) {
  fields("black_level", projector.black_level);
  fields("gamma", projector.gamma);
  fields("defocus_px", projector.defocus_px);
  fields("falloff", projector.falloff);
  fields("intensity", projector.intensity);
  fields("lens", projector.lens);
  fields("projector_from_world", projector.projector_from_world);
}

template <class Fields>
void describe(Fields& fields, SensorModel& sensor) {
  fields("bit_depth", sensor.bit_depth);
  fields("electrons_full_scale", sensor.electrons_full_scale);
  fields("read_noise_electrons", sensor.read_noise_electrons);
  fields("noise_scale", sensor.noise_scale);
  fields("black_level", sensor.black_level);
  fields("response_strength", sensor.response_strength);
  fields("seed", sensor.seed);
  fields.named("encoding", sensor.encoding, capture::encoding_names);
}

template <class Fields>
void describe(Fields& fields, Truth& truth) {
  fields.format("kappamu-truth");
  fields.object("units", [](auto& inner) {
    inner.fixed("length", "mm", "simulate again");
    inner.fixed("time", "s", "simulate again");
  });
  fields("sample", truth.sample);
  fields("seed", truth.seed);
  fields("channels", truth.channels);
  fields("grid", truth.grid);
  fields.object("transport", [&](auto& inner) {
    inner("model", truth.transport_model);
    inner("grid", truth.transport_grid);
    inner("backend", truth.transport_backend);
  });
  fields("eta", truth.eta);
  fields.named("setup", truth.setup, capture::setup_names);
  fields.named("lit_face", truth.lit_face, face_names);
  fields.named("seen_face", truth.seen_face, face_names);
  fields.named("sides", truth.sides, sides_names);
  fields("holdout", truth.holdout);
  fields("camera", truth.camera_lens);
  fields("projector", truth.projector);
  fields("world_from_sample", truth.world_from_sample);
  fields("world_from_camera", truth.world_from_camera);
  fields("calibration_station", truth.calibration_station);
  fields("pattern_station", truth.pattern_station);
  fields("sensor", truth.sensor);
  fields("responsivity", truth.responsivity);
}

void write_truth(const std::filesystem::path& folder, const Truth& truth) {
  const std::filesystem::path file = folder / "truth.json";
  Truth written = truth;
  io::write_text_atomically(file, io::FieldWriter::written(written).text(file));
}

Truth read_truth(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "truth.json";
  Truth truth;
  io::FieldReader::read(io::JsonDocument(file, "simulate again").root(), truth);
  for (const std::string& channel : truth.channels) {
    require_plain_name(channel, file.string() + ": a name in channels");
  }
  return truth;
}

}  // namespace synthetic
}  // namespace kappamu
