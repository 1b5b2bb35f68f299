#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file_name.h"
#include "io/atomic_file.h"
#include "io/json_node.h"
#include "io/volume/npy_volume.h"
#include "io/volume/volume_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

constexpr const char* format_name = "kappamu-volume";

}  // namespace

std::string volume_json(const VolumeSet& set) {
  const GridShape& shape = set.shape();
  nlohmann::ordered_json json{{"format", format_name},
                              {"version", 1},
                              {"grid", {shape.nx, shape.ny, shape.nz}},
                              {"voxel_mm", shape.voxel_mm}};
  if (set.eta) json["eta"] = *set.eta;
  json["channels"] = set.channels;
  for (const NamedVolume& named : named_volumes(set)) json["units"][named.name] = named.unit;
  json["order"] = "[z][y][x], C order, x fastest";
  json["frame"] =
      "mm, origin at the block's corner; voxel (i, j, k) is cell-centred at ((i+1/2) h, (j+1/2) h, "
      "(k+1/2) h)";
  json["provenance"] = set.metadata;
  return json.dump(2) + "\n";
}

void write_volume_folder(const fs::path& folder, const VolumeSet& set) {
  validate(set, folder.string());
  std::error_code ignored;
  fs::remove(folder / "volume.json", ignored);
  for (const NamedVolume& named : named_volumes(set)) {
    write_npy_volume(folder / (named.name + ".npy"), *named.volume);
  }
  write_text_atomically(folder / "volume.json", volume_json(set));
}

void check_voxels(const fs::path& file, const GridShape& shape, std::size_t volumes,
                  std::size_t most_voxels) {
  if (shape.cells() * volumes <= most_voxels) return;
  throw InputError(file.string() + ": " + std::to_string(volumes) + " volumes of " +
                       std::to_string(shape.nx) + " x " + std::to_string(shape.ny) + " x " +
                       std::to_string(shape.nz) + " voxels are more than the " +
                       std::to_string(most_voxels) +
                       " voxels allowed; allow more if the file is meant so",
                   {{"max_voxels"}});
}

VolumeSet read_volume_folder(const fs::path& folder, std::size_t most_voxels) {
  const JsonDocument document(folder / "volume.json", "docs/formats.md");
  const JsonNode header = document.root();
  header.expect_fields({"format", "version", "grid", "voxel_mm", "channels", "units"},
                       {"eta", "order", "frame", "provenance"});
  header.expect_format(format_name);
  const auto [nx, ny, nz] = header["grid"].grid();
  const GridShape shape{nx, ny, nz, header["voxel_mm"].number()};
  if (!(shape.voxel_mm > 0.0)) header["voxel_mm"].fail("must be positive");
  VolumeSet set;
  set.channels = header["channels"].names();
  if (header.has("eta")) set.eta = header["eta"].number();
  if (header.has("provenance")) {
    for (const auto& [name, value] : header["provenance"].members()) {
      set.metadata[name] = value.text();
    }
  }
  const JsonNode units = header["units"];
  check_voxels(folder / "volume.json", shape, units.members().size(), most_voxels);
  for (const std::string& channel : set.channels) {
    set.media.push_back({read_npy_volume(folder / ("kappa_" + channel + ".npy"), shape),
                         read_npy_volume(folder / ("mu_" + channel + ".npy"), shape)});
    // volume.json lists what belongs to it; other arrays may be left over from an older volume.
    const auto read_extra = [&](const std::string& prefix, std::vector<Volume<double>>& volumes) {
      const std::string name = prefix + channel;
      if (units.has(name)) {
        volumes.push_back(read_npy_volume(folder / (name + ".npy"), shape));
      }
    };
    read_extra("std_kappa_", set.kappa_std);
    read_extra("std_mu_", set.mu_std);
    read_extra("resolution_kappa_", set.kappa_resolution);
    read_extra("resolution_mu_", set.mu_resolution);
    read_extra("sensitivity_", set.sensitivity);
  }
  validate(set, folder.string());
  return set;
}

fs::path find_volume(const fs::path& path) {
  if (!fs::is_directory(path)) return path;
  for (const fs::path& candidate : {path / "volume.vdb", path / "fit" / "volume.vdb"}) {
    if (fs::exists(candidate)) return candidate;
  }
  for (const fs::path& candidate : {path, path / "fit"}) {
    if (fs::exists(candidate / "volume.json")) return candidate;
  }
  throw InputError(path.string() +
                   ": has no volume.vdb, fit/volume.vdb or volume.json; give a .vdb file, a "
                   "finished run, or a folder of arrays with volume.json");
}

fs::path find_shown_volume(const fs::path& path) {
  const fs::path volume = find_volume(path);
  const fs::path coarse = volume / "coarse";
  return fs::exists(coarse / "volume.json") ? coarse : volume;
}

VolumeSet read_volume(const fs::path& path, std::size_t most_voxels) {
  if (fs::is_directory(path)) return read_volume_folder(path, most_voxels);
  if (!fs::exists(path)) {
    throw InputError("cannot read " + path.string() + ": there is no such file or folder");
  }
  if (lower_extension(path) != ".vdb") {
    throw InputError(path.string() + ": must be a .vdb file or a folder with volume.json");
  }
  return read_vdb(path, most_voxels);
}

}  // namespace kappamu::io
