#include "io/volume/volume_export.h"

#include "core/shown_text.h"
#include "io/image/exr.h"
#include "io/volume/volume_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

ExportResult export_npy(const fs::path& folder, const VolumeSet& set) {
  write_volume_folder(folder, set);
  ExportResult result;
  for (const NamedVolume& named : named_volumes(set)) {
    result.files.push_back(folder / (named.name + ".npy"));
  }
  result.files.push_back(folder / "volume.json");
  return result;
}

ExportResult export_vdb(const fs::path& file, const VolumeSet& set) {
  write_vdb(file, set);
  return {{file}, {}};
}

ExportResult export_slices(const fs::path& folder, const VolumeSet& set) {
  validate(set, folder.string());
  const GridShape& shape = set.shape();
  ExportResult result;
  for (int z = 0; z < shape.nz; ++z) {
    ExrImage image{shape.nx, shape.ny, {}, {}};
    for (const NamedVolume& named : named_volumes(set)) {
      // "kappa_R" is channel R of layer kappa.
      const std::size_t split = named.name.rfind('_');
      std::vector<float>& values =
          image.channels[named.name.substr(0, split) + "." + named.name.substr(split + 1)];
      const double* layer = named.volume->values().data() + shape.index(0, 0, z);
      const std::size_t pixels = static_cast<std::size_t>(shape.nx) * shape.ny;
      values.assign(layer, layer + pixels);
    }
    image.attributes = {{"units", "kappa mm, mu 1/mm"},
                        {"pixel", std::to_string(shape.voxel_mm) + " mm, x right, y down"},
                        {"z", std::to_string((z + 0.5) * shape.voxel_mm) + " mm"}};
    const fs::path file = folder / formatted("slice_%03d.exr", z);
    write_exr(file, image);
    result.files.push_back(file);
  }
  return result;
}

}  // namespace kappamu::io
