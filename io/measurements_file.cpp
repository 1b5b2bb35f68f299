#include "io/measurements_file.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/npy.h"
#include "io/read_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::string_view format_name = "kappamu-measurements";
constexpr int format_version = 1;
constexpr std::array<std::string_view, 11> field_names{
    "format",    "version",  "voxel_mm", "grid",  "eta",     "lit_face",
    "seen_face", "quantity", "light",    "sides", "channels"};

/// measurements.json with its fields checked; every complaint names file and field.
class Header {
 public:
  explicit Header(const fs::path& file) : file_(file.string()) {
    try {
      json_ = json::parse(read_text(file));
    } catch (const json::parse_error& error) {
      throw InputError(file_ + ": not valid JSON near byte " + std::to_string(error.byte));
    }
    if (!json_.is_object()) throw InputError(file_ + ": must hold one JSON object");
    for (const auto& [name, value] : json_.items()) {
      if (std::find(field_names.begin(), field_names.end(), name) == field_names.end()) {
        throw InputError(file_ + ": unknown field '" + name + "'; remove it or correct its name");
      }
    }
  }

  std::string text(const char* name) const {
    const json& value = field(name);
    if (!value.is_string()) fail(name, "must be a string");
    return value.get<std::string>();
  }
  double number(const char* name) const {
    const json& value = field(name);
    if (!value.is_number()) fail(name, "must be a number");
    return value.get<double>();
  }
  const json& array(const char* name) const {
    const json& value = field(name);
    if (!value.is_array()) fail(name, "must be an array");
    return value;
  }
  /// A string through one of core's readers of names.
  template <class T>
  T named(const char* name, T (*from_string)(const std::string&)) const {
    try {
      return from_string(text(name));
    } catch (const InputError& error) {
      throw InputError(file_ + ": field '" + name + "': " + error.what());
    }
  }
  [[noreturn]] void fail(const char* name, const std::string& why) const {
    throw InputError(file_ + ": field '" + name + "' " + why);
  }

 private:
  const json& field(const char* name) const {
    const auto found = json_.find(name);
    if (found == json_.end()) fail(name, "is missing");
    return *found;
  }

  std::string file_;
  json json_;
};

std::array<int, 3> read_grid(const Header& header) {
  const json& values = header.array("grid");
  std::array<int, 3> grid{};
  constexpr int largest = 1 << 16;
  if (values.size() != grid.size()) header.fail("grid", "must be [nx, ny, nz]");
  for (std::size_t axis = 0; axis < grid.size(); ++axis) {
    const json& extent = values[axis];
    if (!extent.is_number_integer() || extent < 1 || extent > largest) {
      header.fail("grid", "must be three whole numbers from 1 to 65536");
    }
    grid[axis] = extent.get<int>();
  }
  return grid;
}

std::vector<std::string> read_channels(const Header& header) {
  std::vector<std::string> names;
  for (const json& name : header.array("channels")) {
    if (!name.is_string() || name.get<std::string>().empty()) {
      header.fail("channels", "must hold names such as \"R\"");
    }
    names.push_back(name.get<std::string>());
    if (std::find(names.begin(), names.end() - 1, names.back()) != names.end() - 1) {
      header.fail("channels", "names '" + names.back() + "' twice");
    }
  }
  if (names.empty()) header.fail("channels", "must name at least one channel");
  return names;
}

}  // namespace

SurfaceMeasurements read_measurements(const fs::path& folder) {
  const Header header(folder / "measurements.json");
  if (header.text("format") != format_name) {
    header.fail("format", "is not \"" + std::string(format_name) + "\"");
  }
  if (header.number("version") != format_version) {
    header.fail("version", "must be 1; this program reads no other");
  }
  SurfaceMeasurements m;
  const auto [nx, ny, nz] = read_grid(header);
  m.grid = {nx, ny, nz, header.number("voxel_mm")};
  m.eta = header.number("eta");
  m.lit_face = header.named("lit_face", face_from_string);
  m.seen_face = header.named("seen_face", face_from_string);
  m.quantity = header.named("quantity", quantity_from_string);
  m.light = header.named("light", light_from_string);
  m.sides = header.named("sides", sides_from_string);
  m.channels = read_channels(header);

  NpyArray irradiance = read_npy(folder / "irradiance.npy");
  const auto lit_v = static_cast<std::size_t>(m.lit_shape().nv);
  const auto lit_u = static_cast<std::size_t>(m.lit_shape().nu);
  if (irradiance.shape.size() != 3 || irradiance.shape[1] != lit_v ||
      irradiance.shape[2] != lit_u) {
    throw InputError((folder / "irradiance.npy").string() + ": array has shape " +
                     shape_to_string(irradiance.shape) + " instead of [patterns]" +
                     shape_to_string({lit_v, lit_u}) + ", the lit face " + to_string(m.lit_face));
  }
  const std::size_t patterns = irradiance.shape[0];
  m.patterns = static_cast<int>(patterns);
  m.irradiance = std::move(irradiance.values);

  const std::vector<std::size_t> seen{m.channels.size(), patterns,
                                      static_cast<std::size_t>(m.seen_shape().nv),
                                      static_cast<std::size_t>(m.seen_shape().nu)};
  m.value = read_npy(folder / "value.npy", seen).values;
  m.variance = read_npy(folder / "variance.npy", seen).values;
  if (fs::exists(folder / "mask.npy")) {
    const NpyArray mask = read_npy(folder / "mask.npy", seen);
    for (const float use : mask.values) {
      if (use != 0.0F && use != 1.0F) {
        throw InputError((folder / "mask.npy").string() + ": values must be 0 or 1");
      }
      m.mask.push_back(use == 1.0F ? 1 : 0);
    }
  }
  validate(m, folder.string());
  return m;
}

void write_measurements(const fs::path& folder, const SurfaceMeasurements& m) {
  validate(m, folder.string());
  // Without its header the folder is no measurement: neither a mixture of old and new arrays nor a
  // half-written one can be read.
  std::error_code ignored;
  fs::remove(folder / "measurements.json", ignored);
  fs::remove(folder / "mask.npy", ignored);

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
  const nlohmann::ordered_json header{{"format", format_name},
                                      {"version", format_version},
                                      {"voxel_mm", m.grid.voxel_mm},
                                      {"grid", {m.grid.nx, m.grid.ny, m.grid.nz}},
                                      {"eta", m.eta},
                                      {"lit_face", to_string(m.lit_face)},
                                      {"seen_face", to_string(m.seen_face)},
                                      {"quantity", to_string(m.quantity)},
                                      {"light", to_string(m.light)},
                                      {"sides", to_string(m.sides)},
                                      {"channels", m.channels}};
  write_text_atomically(folder / "measurements.json", header.dump(2) + "\n");
}

}  // namespace kappamu::io
