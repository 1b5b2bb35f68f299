#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "io/volume/volume_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/stages/export_stage.h"
#include "render/scene/material_export.h"

namespace kappamu::app {

namespace {

struct ExportOptions {
  std::string volume;
  std::string out;
  std::vector<std::string> formats{"all"};
  std::size_t most_voxels = io::default_most_voxels;
};

/// Not among the pipeline's: a mean, which says less than the volume.
constexpr const char* material_format = "material";

void add_material(const ExportOptions& options, const std::filesystem::path& folder,
                  Progress& progress, io::ExportResult& result) {
  const io::VolumeSet set = io::read_volume(io::find_volume(options.volume), options.most_voxels);
  const io::ExportResult made = render::export_material(folder, set);
  for (const std::string& warning : made.warnings) progress.warn(warning);
  result.files.insert(result.files.end(), made.files.begin(), made.files.end());
  result.warnings.insert(result.warnings.end(), made.warnings.begin(), made.warnings.end());
}

void run_export(const ExportOptions& options, const Globals& globals) {
  const auto progress = make_progress();
  pipeline::OutputFolder out(
      options.out, "export", {io::find_volume(options.volume)},
      {"volume.vti", "mitsuba", "medium.pbrt", "npy", "volume.vdb", "exr", "material"},
      pipeline::Former::kept);
  std::vector<std::string> formats = options.formats;
  const bool material = std::erase(formats, material_format) > 0;
  io::ExportResult result;
  if (!formats.empty()) {
    result = pipeline::export_volumes(options.volume, out.partial(), formats, *progress,
                                      options.most_voxels);
  }
  if (material) add_material(options, out.partial() / "material", *progress, result);
  for (auto& file : result.files)
    file = std::filesystem::path(options.out) / file.lexically_relative(out.partial());
  out.commit();
  if (globals.json) {
    nlohmann::ordered_json json{{"volume", io::find_volume(options.volume).string()},
                                {"files", nlohmann::json::array()},
                                {"warnings", result.warnings}};
    for (const auto& file : result.files) json["files"].push_back(file.string());
    print_json(json);
    return;
  }
  for (const auto& file : result.files) std::printf("%s\n", file.c_str());
}

}  // namespace

void add_export(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand("export",
                                     R"(Write κ and μ volumes in the formats of other programs.

VOLUME is a .vdb file, a run folder of `kappamu run` or `kappamu fit`, or a folder with
volume.json and kappa_R.npy, mu_R.npy, ... Into OUT go, by --format:

  vti  volume.vti   ParaView, VTK: cell data kappa [mm], mu [1/mm], sigma_t, albedo
  vol  mitsuba/     Mitsuba 3: sigma_t.vol, albedo.vol, one pair per channel, scene.xml
  pbrt medium.pbrt  pbrt-v4: named medium of type rgbgrid, sigma_a and sigma_s [1/mm]
  npy  npy/         NumPy: float32 [z][y][x] per coefficient and channel, volume.json
  vdb  volume.vdb   OpenVDB: fog grids kappa_R, mu_R, sigma_t_R, albedo_R, ..., density
  exr  exr/         one image per z layer with channels kappa.R, mu.R, ...
  material  material/  the volume's mean as a shader's material: material.mtlx (MaterialX,
                       OpenPBR subsurface colour and radius) and principled.json (Blender)

Lengths are mm, coefficients mm and 1/mm, in every format. Values belong to voxel centres:
voxel (i, j, k) of edge h is centred at ((i+1/2) h, (j+1/2) h, (k+1/2) h), x fastest.
Renderers get sigma_t = 1/(3 kappa) and albedo = 1 - 3 kappa mu, for isotropic scattering;
where 3 kappa mu >= 1 the albedo is set to 0 and a warning counts the voxels. If there are
many, diffusion does not describe the sample, and neither will the render.
A volume with a NaN or with kappa <= 0 is refused (exit code 1).)");
  auto options = std::make_shared<ExportOptions>();
  command->add_option("volume", options->volume, "What to export")->required()->type_name("VOLUME");
  add_out(*command, options->out, "Folder for the files; made if missing");
  std::vector<std::string> names = pipeline::export_formats();
  names.emplace_back("all");
  names.emplace_back(material_format);
  command
      ->add_option(
          "--format", options->formats,
          "vti, vol, pbrt, npy, vdb, exr, material or all but material (default); several with "
          "commas or repeated")
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->type_name("FORMAT");
  add_most_voxels(*command, options->most_voxels);
  command->footer(
      "Prints the files' names; with --json one object with volume, files and warnings.\n"
      "Example: kappamu export demo/run -o demo/export --format vti,vol");
  command->callback([options, &globals] { run_export(*options, globals); });
}

}  // namespace kappamu::app
