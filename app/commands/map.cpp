#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "capture/session/session.h"
#include "capture/session/session_files.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "io/atomic_file.h"
#include "io/measurements_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/sfdi/session_maps.h"
#include "pipeline/sfdi/sfdi_map.h"
#include "pipeline/sfdi/sfdi_output.h"
#include "report/map_page.h"

namespace kappamu::app {

namespace {

namespace sfdi = pipeline::sfdi;

struct MapArguments {
  std::string pictures;
  std::string out;
  sfdi::Scattering scattering;  ///< of sessions and measurements
};

void print_summary(const nlohmann::ordered_json& summary, const std::string& out) {
  for (const auto& map : summary.at("wavelengths")) {
    const auto quantile = [&](const char* name) { return map.at(name).at("median").get<double>(); };
    const auto& pixels = map.at("pixels");
    std::size_t all = 0;
    for (const auto& count : pixels) all += count.get<std::size_t>();
    const std::string label = map.contains("channel")
                                  ? map.at("channel").get<std::string>()
                                  : shown_number(map.at("wavelength_nm").get<double>()) + " nm";
    std::printf("%s: median mua %.4g +- %.2g /mm, mus' %.4g +- %.2g /mm; %zu of %zu pixels\n",
                label.c_str(), quantile("mua"), quantile("mua_deviation"), quantile("musp"),
                quantile("musp_deviation"), pixels.at("good").get<std::size_t>(), all);
    if (!map.contains("region")) continue;
    const auto& region = map.at("region");
    std::printf("  region: mua %.4g +- %.2g /mm, mus' %.4g +- %.2g /mm\n",
                region.at("mua").get<double>(), region.at("mua_deviation").get<double>(),
                region.at("musp").get<double>(), region.at("musp_deviation").get<double>());
  }
  if (summary.contains("spectral")) {
    for (const auto& [name, map] : summary.at("spectral").items()) {
      if (map.at("value").is_null()) continue;
      std::printf("%s: median %.4g +- %.2g %s\n", name.c_str(),
                  map.at("value").at("median").get<double>(),
                  map.at("deviation").at("median").get<double>(),
                  map.at("unit").get<std::string>().c_str());
    }
  }
  std::printf("%s/maps.html\n%s/maps.exr\n", out.c_str(), out.c_str());
}

void run_map(const MapArguments& arguments, Globals& globals) {
  const auto progress = make_progress();
  const Stopwatch watch;
  const std::filesystem::path input = arguments.pictures;
  const bool session = std::filesystem::exists(input / "session.json");
  const bool measurements = std::filesystem::exists(input / "measurements.json");
  sfdi::SessionMaps made;
  if (!session && !measurements) made.description = sfdi::read_description(input);
  std::vector<std::string> files = sfdi::map_files(made.description);
  files.insert(files.end(), {"maps.png", "maps.html"});
  if (session) {
    files.insert(files.end(), {"calibration", "hdr", "measurements", "measurements_validate"});
  }
  pipeline::OutputFolder out(arguments.out, "map",
                             {session || measurements ? input : made.description.folder}, files);
  if (session) {
    const capture::Session read = capture::read_session(input);
    capture::require_files_inside(read);
    made = sfdi::maps_of_session(read, arguments.scattering, out.partial(), *progress);
  } else if (measurements) {
    made = sfdi::maps_of_measurements(io::read_measurements(input), arguments.scattering,
                                      (input / "measurements.json").string());
  } else {
    made.maps = sfdi::measure_maps(made.description, *progress);
  }
  const sfdi::Maps& maps = made.maps;
  const sfdi::Description& description = made.description;
  const nlohmann::ordered_json summary = sfdi::summary_of(maps, description, watch.seconds());
  sfdi::write_maps(maps, out.partial());
  report::write_map_picture(maps, out.partial() / "maps.png");
  report::write_map_page(maps, out.partial() / "maps.html");
  io::write_text_atomically(out.partial() / "summary.json", summary.dump(2) + "\n");
  out.commit();
  for (const std::string& warning : maps.warnings) progress->warn(warning);
  if (globals.json) {
    print_json(summary);
  } else {
    print_summary(summary, arguments.out);
  }
}

}  // namespace

void add_map(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("map",
                         R"(Map absorption and scattering from pictures under sinusoidal light.

PICTURES is a folder with sfdi.json, or such a file (docs/sfdi.md has its fields): pictures of
a sample under sinusoids of one or more spatial frequencies, one or more wavelengths, three or
more phases or a single picture, beside the same pictures of a phantom of known coefficients,
or a scale. Every pixel is measured by itself, as a homogeneous half-space (or a slab of
stated thickness) of anisotropic scattering; transport by a table, not diffusion.

PICTURES may also be a front-lit capture session under sinusoids (`kappamu plan --sinusoids`),
or surface measurements of one: frequencies and phases are found in the calibrated light, the
white target is the scale, index and thickness are the session's. Lit pixels, which a fit by
diffusion leaves out, are what is measured here.

OUT/maps.html and maps.png show the maps; mua.npy, musp.npy, kappa.npy with *_deviation.npy
are float32 [wavelength][y][x] in 1/mm and mm, not a number where not valid; verdict.npy says
why (0 good, 1 no light or saturated, 2 no medium has this reflectance, 3 outside the table);
maps.exr holds all of them; summary.json the medians, checks and causes of the deviations.

Several wavelengths give the law of scattering, A (wavelength/500 nm)^-b, and, where sfdi.json
names "spectra", amounts of absorbers: haemoglobin with and without oxygen and its saturation,
water, fat, melanin, or those of a table of your own.

Deviations are standard deviations: of the pixels' noise, the errors that pictures share, the
phantom's coefficients, the refractive index and g as stated, and the table. Where the sample
changes within a few millimetres, light from neighbours matters and the maps are smoothed; a
fit of a volume takes it into account, from the medians that a warning has:
kappamu fit MEASUREMENTS --start-kappa KAPPA --start-mu MU.)");
  auto arguments = std::make_shared<MapArguments>();
  command
      ->add_option("pictures", arguments->pictures,
                   "Folder with sfdi.json, or that file; a session or surface measurements")
      ->required()
      ->type_name("PICTURES");
  add_out(*command, arguments->out, "Folder of the maps");
  command
      ->add_option("--anisotropy", arguments->scattering.anisotropy,
                   "g of a session's sample, 0.7 to 0.95")
      ->capture_default_str()
      ->type_name("G");
  command
      ->add_option("--anisotropy-deviation", arguments->scattering.anisotropy_deviation,
                   "Its standard deviation")
      ->type_name("D");
  command
      ->add_option("--index-deviation", arguments->scattering.index_deviation,
                   "Standard deviation of a session's refractive index")
      ->type_name("D");
  command->footer("Example: kappamu map pictures -o maps");
  command->callback([arguments, &globals] { run_map(*arguments, globals); });
}

}  // namespace kappamu::app
