#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/session_command.h"
#include "pipeline/pipeline.h"

namespace kappamu::app {

namespace {

void run_merge(const SessionCommand& options, const Globals& globals) {
  const auto progress = make_progress();
  pipeline::Pipeline stages(options.session, options.run, options.force, options.follow_links);
  stages.set_hdr_options(options.hdr);
  const bool worked = stages.merge(*progress);
  const std::filesystem::path& run = stages.folder().path();
  const double seconds = stages.folder().record().stages.at("merge").seconds;
  const bool measured = std::filesystem::exists(run / "measurements" / "measurements.json");
  if (globals.json) {
    nlohmann::json object{{"hdr", (run / "hdr").string()},
                          {"patterns", stages.session()->patterns.size()},
                          {"measurements", nullptr},
                          {"seconds", seconds}};
    if (measured) object["measurements"] = (run / "measurements").string();
    std::printf("%s\n", object.dump().c_str());
    return;
  }
  std::printf("%zu HDR images  %s  (%s)\n", stages.session()->patterns.size(),
              (run / "hdr").c_str(), time_taken(worked, seconds).c_str());
  if (measured) std::printf("surface values %s\n", (run / "measurements").c_str());
}

}  // namespace

void add_merge(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "merge",
      "Merge each pattern's exposures into an HDR image and measure the surface.\n\n"
      "Writes RUN/hdr/<pattern>.exr: radiance R, G, B [full scales/s], its variance and flags\n"
      "(1 saturated, 2 dark, 4 missing). Where RUN is calibrated (`kappamu calibrate`), also\n"
      "RUN/measurements and RUN/measurements_validate: mean exitance and variance of every "
      "surface\n"
      "voxel, which `kappamu fit` reads (docs/formats.md). A pixel saturated in every exposure is\n"
      "left out of the fit: add a shorter exposure when the report shows many.\n\n"
      "The frames of a stack must show one scene under one light: a frame that is brighter,\n"
      "shifted or partly changed against the rest is refused by name (docs/hdr.md). Give\n"
      "`calibrate` and `merge` the same options; --response takes effect in `calibrate`.");
  const auto options = add_session_options(*command);
  command->footer("Example: kappamu merge demo/session -o demo/run");
  command->callback([options, &globals] { run_merge(*options, globals); });
}

}  // namespace kappamu::app
