#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/hdr_options.h"
#include "app/options/fit_options.h"
#include "app/session_command.h"
#include "pipeline/pipeline.h"
#include "pipeline/records/fit_record.h"
#include "report/report.h"

namespace kappamu::app {

namespace {

using nlohmann::json;

struct RunOptions {
  std::string input;
  std::string run;
  bool force = false;
  capture::Links links = capture::Links::within;
  capture::MergeOptions hdr;
  pipeline::FitStageOptions fit = pipeline::usual_options();
};

/// What the command shows at the end is read from the run folder: a run that was complete shows the
/// same as the one that completed it.
json to_json(const pipeline::FitRecord& fit, const std::string& sample,
             const pipeline::RunFolder& folder) {
  nlohmann::ordered_json object{{"sample", sample}};
  pipeline::add_fit_record(fit, object);
  json seconds = json::object();
  json warnings = json::array();
  double total = 0.0;
  for (const char* name : pipeline::stage_names)
    if (const auto stage = folder.record().stages.find(name);
        stage != folder.record().stages.end()) {
      seconds[name] = stage->second.seconds;
      total += stage->second.seconds;
      for (const std::string& warning : stage->second.warnings) warnings.push_back(warning);
    }
  object["kappa_mu_volume"] = (folder.path() / "fit" / "volume.vdb").string();
  object["report"] = (folder.path() / "report.html").string();
  object["seconds"] = seconds;
  object["seconds_total"] = total;
  object["device"] = folder.record().device;
  object["warnings"] = warnings;
  return object;
}

void print_table(const pipeline::FitRecord& fit, const pipeline::RunFolder& folder) {
  if (fit.camera_rms_px) std::printf("camera reprojection RMS      %.3f px\n", *fit.camera_rms_px);
  if (fit.projector_rms_px)
    std::printf("projector reprojection RMS   %.3f px\n", *fit.projector_rms_px);
  if (fit.validation_E)
    std::printf("validation error E           %.2e  (noise alone %.1e)\n", *fit.validation_E,
                *fit.validation_noise_E);
  std::printf("fit                          %s\n", fit.status.c_str());
  for (const char* name : pipeline::stage_names)
    if (const auto stage = folder.record().stages.find(name); stage != folder.record().stages.end())
      std::printf("time: %-22s %.1f s\n", name, stage->second.seconds);
  std::printf("volumes                      %s\n", (folder.path() / "fit" / "volume.vdb").c_str());
  std::printf("report                       %s\n", (folder.path() / "report.html").c_str());
  std::printf("%s\n", fit.verdict.sentence.c_str());
}

void run_run(const CLI::App& app, RunOptions& options, Globals& globals) {
  const auto progress = make_progress();
  take_globals(app, globals, options.fit);
  const pipeline::FitStageOptions fit = pipeline::resolve(options.fit);
  pipeline::Pipeline stages(options.input, options.run,
                            {.replace_other_run = options.force, .links = options.links});
  stages.require_room();
  stages.folder().set_options(pipeline::options_by_name(fit));
  if (stages.session()) stages.set_hdr_options(options.hdr);
  if (stages.session()) {
    stages.calibrate(*progress);
    stages.merge(*progress);
  }
  stages.fit(fit, *progress);
  stages.export_all(*progress);
  stages.report(report::write_report, *progress);

  const pipeline::FitRecord record = pipeline::read_fit_record(stages.folder().path() / "fit");
  const std::string sample = stages.session() ? stages.session()->sample.name
                                              : stages.folder().record().input.filename().string();
  if (globals.json)
    print_json(to_json(record, sample, stages.folder()));
  else
    print_table(record, stages.folder());
  globals.exit_code = record.verdict.exit_code();
}

}  // namespace

void add_run(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "run",
      R"(Do everything: from a capture session to volumes of κ and μ and a report.

INPUT is a folder with session.json: calibrate, merge, fit, export, report. Or a folder with
measurements.json from any rig or program: fit, export, report. RUN then holds calibration/,
hdr/, measurements/, measurements_validate/, fit/ (volume.vdb, kappa_R.npy ... [mm],
mu_R.npy ... [1/mm]), export/ and report.html (docs/formats.md).

Each stage that is complete for the same inputs, options and program is skipped; killed at
any moment and started again, the command goes on where it was and ends in the same bits. A
RUN made from another input is refused.

The validation error E = Σ(L' − L)²/ΣL² compares photographs under light that the fit never
saw with what the volumes predict: below 1e-3, or close to what the photographs' noise alone
makes, is good. The last line is the verdict: whether to trust the fit, and if not, why.)");
  auto options = std::make_shared<RunOptions>();
  command->add_option("input", options->input, "Session folder, or folder of measurements")
      ->required()
      ->type_name("INPUT");
  add_out(*command, options->run, "Run folder; made if missing", "RUN");
  command->add_flag("--force", options->force, "Do every stage again, replacing what RUN holds");
  add_follow_links(*command, options->links);
  add_hdr_options(*command, options->hdr);
  add_fit_options(*command, options->fit);
  command->footer(
      R"(Exit code 3: a channel ran out of steps, its data are not explained to their noise, or the
verdict is red; everything is kept, and the report shows why.
With --json the last line is one object: sample, grid, status, verdict, validation_E,
validation_noise_E, camera_rms_px, projector_rms_px, kappa_mu_volume, report, seconds by
stage, seconds_total, device, warnings.
Example: kappamu run demo/session -o demo/run)");
  command->callback([command, options, &globals] { run_run(*command, *options, globals); });
}

}  // namespace kappamu::app
