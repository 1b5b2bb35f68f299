#include "io/measurements_file.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/json_node.h"
#include "io/npy.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

constexpr const char* format_name = "kappamu-measurements";

constexpr std::size_t most_patterns = 1 << 16;

/// The face of each pattern, where there are two.
void read_seen_faces(const JsonNode& list, SurfaceMeasurements& m) {
  for (const JsonNode& face : list.items(1)) m.seen_faces.push_back(face.named(face_from_string));
}

void read_cameras(const JsonNode& faces, SurfaceMeasurements& m) {
  faces.expect_fields({}, {"x-", "x+", "y-", "y+", "z-", "z+"});
  for (const Face face : all_faces) {
    const std::string name = to_string(face);
    if (!faces.has(name)) continue;
    const std::vector<JsonNode> place = faces[name.c_str()].exactly(3);
    for (int a = 0; a < 3; ++a) m.cameras[face][a] = place[static_cast<std::size_t>(a)].number();
  }
}

/// Empty where there is no file.
std::vector<std::uint8_t> read_flags(const fs::path& file, const std::vector<std::size_t>& shape) {
  std::vector<std::uint8_t> flags;
  if (!fs::exists(file)) return flags;
  for (const float flag : read_npy(file, shape).values) {
    if (flag != 0.0F && flag != 1.0F) {
      throw InputError(file.string() + ": values must be 0 or 1");
    }
    flags.push_back(flag == 1.0F ? 1 : 0);
  }
  return flags;
}

}  // namespace

SurfaceMeasurements read_measurements_header(const fs::path& folder) {
  const JsonDocument document(folder / "measurements.json", "docs/formats.md");
  const JsonNode header = document.root();
  header.expect_fields({"format", "version", "voxel_mm", "grid", "eta", "lit_face", "seen_face",
                        "quantity", "light", "sides", "channels"},
                       {"seen_faces", "smooth_error", "camera_mm"});
  header.expect_format(format_name);
  SurfaceMeasurements m;
  const auto [nx, ny, nz] = header["grid"].grid();
  m.grid = {nx, ny, nz, header["voxel_mm"].number()};
  m.eta = header["eta"].number();
  m.lit_face = header["lit_face"].named(face_from_string);
  m.seen_face = header["seen_face"].named(face_from_string);
  if (header.has("seen_faces")) read_seen_faces(header["seen_faces"], m);
  if (header.has("camera_mm")) read_cameras(header["camera_mm"], m);
  m.quantity = header["quantity"].named(quantity_from_string);
  m.light = header["light"].named(light_from_string);
  m.sides = header["sides"].named(sides_from_string);
  m.channels = header["channels"].names();
  if (header.has("smooth_error")) {
    const JsonNode error = header["smooth_error"];
    error.expect_fields({"common", "own"}, {"source"});
    m.smooth_error = {error["common"].number(), error["own"].number()};
  }
  return m;
}

SurfaceMeasurements read_measurements(const fs::path& folder) {
  SurfaceMeasurements m = read_measurements_header(folder);
  const auto lit_v = static_cast<std::size_t>(m.lit_shape().nv);
  const auto lit_u = static_cast<std::size_t>(m.lit_shape().nu);
  const auto check_shape = [&](const std::vector<std::size_t>& shape) {
    if (shape.size() == 3 && shape[0] <= most_patterns && shape[1] == lit_v && shape[2] == lit_u) {
      return;
    }
    throw InputError((folder / "irradiance.npy").string() + ": array has shape " +
                     shape_to_string(shape) + " instead of [patterns]" +
                     shape_to_string({lit_v, lit_u}) + ", the lit face " + to_string(m.lit_face));
  };
  NpyArray irradiance = read_npy(folder / "irradiance.npy", check_shape);
  const std::size_t patterns = irradiance.shape[0];
  m.patterns = static_cast<int>(patterns);
  m.irradiance = std::move(irradiance.values);

  const std::vector<std::size_t> seen{m.channels.size(), patterns,
                                      static_cast<std::size_t>(m.seen_shape().nv),
                                      static_cast<std::size_t>(m.seen_shape().nu)};
  m.value = read_npy(folder / "value.npy", seen).values;
  m.variance = read_npy(folder / "variance.npy", seen).values;
  m.mask = read_flags(folder / "mask.npy", seen);
  m.lit = read_flags(folder / "lit.npy", seen);
  validate(m, folder.string());
  return m;
}

void write_measurements(const fs::path& folder, const SurfaceMeasurements& m,
                        const std::string& smooth_error_source) {
  validate(m, folder.string());
  // Without its header the folder is no measurement: neither a mixture of old and new arrays nor a
  // half-written one can be read.
  std::error_code ignored;
  fs::remove(folder / "measurements.json", ignored);
  fs::remove(folder / "mask.npy", ignored);
  fs::remove(folder / "lit.npy", ignored);

  const auto patterns = static_cast<std::size_t>(m.patterns);
  const auto extent = [](int n) { return static_cast<std::size_t>(n); };
  const std::vector<std::size_t> seen{m.channels.size(), patterns, extent(m.seen_shape().nv),
                                      extent(m.seen_shape().nu)};
  write_npy(folder / "irradiance.npy",
            {patterns, extent(m.lit_shape().nv), extent(m.lit_shape().nu)},
            std::span<const float>(m.irradiance));
  write_npy(folder / "value.npy", seen, std::span<const float>(m.value));
  write_npy(folder / "variance.npy", seen, std::span<const float>(m.variance));
  if (!m.mask.empty()) {
    write_npy(folder / "mask.npy", seen, std::span<const std::uint8_t>(m.mask));
  }
  if (!m.lit.empty()) {
    write_npy(folder / "lit.npy", seen, std::span<const std::uint8_t>(m.lit));
  }
  nlohmann::ordered_json fields{{"format", format_name},
                                {"version", 1},
                                {"voxel_mm", m.grid.voxel_mm},
                                {"grid", {m.grid.nx, m.grid.ny, m.grid.nz}},
                                {"eta", m.eta},
                                {"lit_face", to_string(m.lit_face)},
                                {"seen_face", to_string(m.seen_face)},
                                {"quantity", to_string(m.quantity)},
                                {"light", to_string(m.light)},
                                {"sides", to_string(m.sides)},
                                {"channels", m.channels}};
  for (const Face face : m.seen_faces) fields["seen_faces"].push_back(to_string(face));
  for (const auto& [face, camera] : m.cameras) {
    fields["camera_mm"][to_string(face)] = {camera.x(), camera.y(), camera.z()};
  }
  if (!m.smooth_error.none()) {
    fields["smooth_error"] = {{"common", m.smooth_error.common}, {"own", m.smooth_error.own}};
    if (!smooth_error_source.empty()) fields["smooth_error"]["source"] = smooth_error_source;
  }
  write_text_atomically(folder / "measurements.json", fields.dump(2) + "\n");
}

}  // namespace kappamu::io
