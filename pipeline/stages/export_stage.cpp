#include "pipeline/stages/export_stage.h"

#include <algorithm>

#include "core/error.h"
#include "io/volume/volume_file.h"
#include "pipeline/surface_reflectance.h"
#include "pipeline/verify.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;

const std::vector<std::string>& export_formats() {
  static const std::vector<std::string> formats{"vti", "vol", "pbrt", "npy", "vdb", "exr"};
  return formats;
}

namespace {

/// Of the sample's surface, where a fit has left it beside the volume.
void copy_reflectance(const fs::path& volume, const fs::path& folder, io::ExportResult& result) {
  const fs::path from = fs::is_directory(volume) ? volume : volume.parent_path();
  for (const Face face : all_faces) {
    const std::string name = reflectance_name(face);
    if (!fs::exists(from / name)) continue;
    fs::copy_file(from / name, folder / name, fs::copy_options::overwrite_existing);
    result.files.push_back(folder / name);
  }
}

}  // namespace

io::ExportResult export_volumes(const fs::path& volume, const fs::path& folder,
                                const std::vector<std::string>& formats, Progress& progress,
                                std::size_t most_voxels) {
  std::vector<std::string> wanted;
  for (const std::string& format : formats) {
    const auto& known = export_formats();
    if (format == "all") {
      wanted = known;
      break;
    }
    if (std::find(known.begin(), known.end(), format) == known.end()) {
      throw InputError("export format '" + format +
                       "' is not one of vti, vol, pbrt, npy, vdb, exr, all");
    }
    if (std::find(wanted.begin(), wanted.end(), format) == wanted.end()) wanted.push_back(format);
  }
  const fs::path source = io::find_volume(volume);
  require_as_written(source);
  const io::VolumeSet set = io::read_volume(source, most_voxels);
  io::ExportResult all;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::string& format = wanted[i];
    progress.update("export", static_cast<double>(i) / static_cast<double>(wanted.size()), format);
    io::ExportResult one;
    if (format == "vti") one = io::export_vti(folder / "volume.vti", set);
    if (format == "vol") one = io::export_mitsuba(folder / "mitsuba", set);
    if (format == "pbrt") one = io::export_pbrt(folder / "medium.pbrt", set);
    if (format == "npy") one = io::export_npy(folder / "npy", set);
    if (format == "vdb") one = io::export_vdb(folder / "volume.vdb", set);
    if (format == "exr") {
      one = io::export_slices(folder / "exr", set);
      copy_reflectance(source, folder / "exr", one);
    }
    all.files.insert(all.files.end(), one.files.begin(), one.files.end());
    for (const std::string& warning : one.warnings) {
      // Formats share their conversion: each warning once.
      if (std::find(all.warnings.begin(), all.warnings.end(), warning) != all.warnings.end()) {
        continue;
      }
      all.warnings.push_back(warning);
      progress.warn(warning);
    }
  }
  progress.update("export", 1.0, std::to_string(all.files.size()) + " files");
  return all;
}

}  // namespace kappamu::pipeline
