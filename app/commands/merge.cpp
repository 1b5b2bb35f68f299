#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/command.h"
#include "app/photograph_options.h"
#include "app/session_command.h"
#include "pipeline/output_folder.h"
#include "pipeline/pipeline.h"
#include "pipeline/stages/photographs.h"

namespace kappamu::app {

namespace {

struct BracketCommand {
  PhotographOptions photographs;
  bool linear = false;
};

void merge_bracket(const SessionCommand& options, const BracketCommand& bracket,
                   const Globals& globals) {
  const auto progress = make_progress();
  pipeline::OutputFolder out(options.run, "merge", {options.session},
                             {"radiance.exr", "response.yml"});
  const pipeline::BracketSummary summary = pipeline::merge_photographs(
      bracket.photographs.source(options.session, options.links),
      bracket.linear ? capture::Encoding::linear : capture::Encoding::response, options.hdr,
      out.partial(), *progress);
  out.commit();
  const std::string file = (out.path() / "radiance.exr").string();
  if (globals.json) {
    print_json({{"radiance", file},
                {"frames", summary.frames},
                {"dark_frames", summary.dark_frames},
                {"saturated_share", summary.saturated_share},
                {"dark_share", summary.dark_share},
                {"darkest", summary.darkest},
                {"brightest", summary.brightest}});
    return;
  }
  std::printf("%zu frames, %zu dark frames; radiance %.3g to %.3g full scales/s\n", summary.frames,
              summary.dark_frames, summary.darkest, summary.brightest);
  std::printf("%.2f %% of the values saturated in every frame, %.2f %% dark in every frame\n",
              100.0 * summary.saturated_share, 100.0 * summary.dark_share);
  std::printf("%s\n", file.c_str());
}

void run_merge(const SessionCommand& options, const BracketCommand& bracket,
               const Globals& globals) {
  if (!is_session(options.session)) return merge_bracket(options, bracket, globals);
  bracket.photographs.require_none(options.session);
  const auto progress = make_progress();
  pipeline::Pipeline stages(options.session, options.run,
                            {.replace_other_run = options.force, .links = options.links});
  stages.set_hdr_options(options.hdr);
  const bool worked = stages.merge(*progress);
  const std::filesystem::path& run = stages.folder().path();
  const double seconds = stages.folder().record().stages.at("merge").seconds;
  const bool measured = std::filesystem::exists(run / "measurements" / "measurements.json");
  const std::optional<calib::SharedError>& shared = stages.shared_error();
  if (globals.json) {
    nlohmann::json object{{"hdr", (run / "hdr").string()},
                          {"patterns", stages.session()->patterns.size()},
                          {"measurements", nullptr},
                          {"seconds", seconds}};
    if (measured) object["measurements"] = (run / "measurements").string();
    if (shared) {
      object["smooth_error"] = {
          {"common", shared->error.common}, {"own", shared->error.own}, {"source", shared->source}};
    }
    print_json(object);
    return;
  }
  std::printf("%zu HDR images  %s  (%s)\n", stages.session()->patterns.size(),
              (run / "hdr").c_str(),
              time_taken(worked ? std::optional(seconds) : std::nullopt).c_str());
  if (measured) std::printf("surface values %s\n", (run / "measurements").c_str());
  if (shared) std::printf("errors that pixels share: %s\n", shared->source.c_str());
}

}  // namespace

void add_merge(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "merge",
      R"(Merge each pattern's exposures into an HDR image and measure the surface.

Writes RUN/hdr/<pattern>.exr: radiance R, G, B [full scales/s], its variance and flags
(1 saturated, 2 dark, 4 missing). Where RUN is calibrated (`kappamu calibrate`), also
RUN/measurements and RUN/measurements_validate: mean exitance and variance of every surface
voxel, which `kappamu fit` reads (docs/formats.md). A pixel saturated in every exposure is
left out of the fit: add a shorter exposure when the report shows many.

The frames of a stack must show one scene under one light: a frame that is brighter,
shifted or partly changed against the rest is refused by name (docs/hdr.md). Give
`calibrate` and `merge` the same options; --response takes effect in `calibrate`.

A folder without session.json is taken as one bracket: every photograph in it a frame,
dark_0 ... frames of the covered lens (without any, black is estimated). Into RUN go
radiance.exr and response.yml; docs/howto/one-stage.md.)");
  const auto options = add_session_options(*command);
  auto bracket = std::make_shared<BracketCommand>();
  add_photograph_options(*command, bracket->photographs);
  command->add_flag("--linear", bracket->linear,
                    "PNG and TIFF of the bracket are linear in light; otherwise their response is "
                    "recovered");
  command->footer(
      "Examples: kappamu merge demo/session -o demo/run\n"
      "          kappamu merge photographs -o hdr --on-motion correct");
  command->callback([options, bracket, &globals] { run_merge(*options, *bracket, globals); });
}

}  // namespace kappamu::app
