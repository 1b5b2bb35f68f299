#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "app/fit_options.h"
#include "app/hdr_options.h"
#include "app/session_command.h"
#include "pipeline/pipeline.h"
#include "report/read/run_data.h"
#include "report/report.h"
#include "report/sections.h"

namespace kappamu::app {

namespace {

using nlohmann::json;

struct RunOptions {
  std::string input;
  std::string run;
  bool force = false;
  bool follow_links = false;
  capture::HdrOptions hdr;
  pipeline::FitStageOptions fit = pipeline::usual_options();
};

/// What the command says at the end, read back from the run folder: a run that was complete says
/// the same as the one that completed it.
struct RunSummary {
  std::string sample;
  GridShape grid;
  std::optional<double> camera_rms_px;
  std::optional<double> projector_rms_px;
  std::optional<report::AppearanceError> holdout;
  bool converged = false;
  std::vector<std::string> warnings;
};

RunSummary summarise(pipeline::Pipeline& stages) {
  const std::filesystem::path& run = stages.folder().path();
  report::RunData data;
  data.folder = run;
  data.session = stages.session();
  data.record = stages.folder().record();
  data.calibration = report::read_calibration(run);
  data.fit = report::read_fit(run);
  report::read_comparisons(data);
  RunSummary summary;
  summary.sample =
      stages.session() ? stages.session()->sample.name : data.record->input.filename().string();
  summary.grid = data.fit->media.front().kappa.shape();
  if (data.calibration) {
    summary.camera_rms_px = data.calibration->camera.rms_px;
    summary.projector_rms_px = data.calibration->projector.rms_px;
  }
  if (data.validate_patterns && !data.validate_patterns->predicted.empty())
    summary.holdout = report::appearance_error(*data.validate_patterns);
  summary.converged = true;
  for (const report::Convergence& channel : data.fit->convergence)
    summary.converged = summary.converged && channel.converged;
  summary.warnings = report::all_warnings(data);
  return summary;
}

json to_json(const RunSummary& summary, const pipeline::RunFolder& folder) {
  const auto optional = [](const std::optional<double>& value) {
    return value ? json(*value) : json(nullptr);
  };
  json seconds = json::object();
  double total = 0.0;
  for (const char* name : pipeline::stage_names)
    if (const auto stage = folder.record().stages.find(name);
        stage != folder.record().stages.end()) {
      seconds[name] = stage->second.seconds;
      total += stage->second.seconds;
    }
  return {{"sample", summary.sample},
          {"grid", {summary.grid.nx, summary.grid.ny, summary.grid.nz}},
          {"camera_rms_px", optional(summary.camera_rms_px)},
          {"projector_rms_px", optional(summary.projector_rms_px)},
          {"holdout_E", summary.holdout ? json(summary.holdout->error) : json(nullptr)},
          {"holdout_noise", summary.holdout ? json(summary.holdout->noise) : json(nullptr)},
          {"holdout_chi2_per_value",
           summary.holdout ? json(summary.holdout->chi2_per_value) : json(nullptr)},
          {"converged", summary.converged},
          {"kappa_mu_volume", (folder.path() / "fit" / "volume.vdb").string()},
          {"report", (folder.path() / "report.html").string()},
          {"seconds", seconds},
          {"seconds_total", total},
          {"device", folder.record().device},
          {"warnings", summary.warnings}};
}

void print_table(const RunSummary& summary, const pipeline::RunFolder& folder) {
  if (summary.camera_rms_px)
    std::printf("camera reprojection RMS      %.3f px\n", *summary.camera_rms_px);
  if (summary.projector_rms_px)
    std::printf("projector reprojection RMS   %.3f px\n", *summary.projector_rms_px);
  if (summary.holdout)
    std::printf("appearance error, held out   %.2e  (noise alone %.1e)\n", summary.holdout->error,
                summary.holdout->noise);
  std::printf("fit                          %s\n",
              summary.converged ? "converged" : "not converged: kept and marked");
  for (const char* name : pipeline::stage_names)
    if (const auto stage = folder.record().stages.find(name); stage != folder.record().stages.end())
      std::printf("time: %-22s %.1f s\n", name, stage->second.seconds);
  std::printf("volumes                      %s\n", (folder.path() / "fit" / "volume.vdb").c_str());
  std::printf("report                       %s\n", (folder.path() / "report.html").c_str());
}

void run_run(const CLI::App& app, RunOptions& options, Globals& globals) {
  const auto progress = make_progress();
  take_globals(app, globals, options.fit);
  const pipeline::FitStageOptions fit = pipeline::resolve(options.fit);
  pipeline::Pipeline stages(options.input, options.run, options.force, options.follow_links);
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

  const RunSummary summary = summarise(stages);
  if (globals.json)
    std::printf("%s\n", to_json(summary, stages.folder()).dump().c_str());
  else
    print_table(summary, stages.folder());
  if (!summary.converged) globals.exit_code = 3;
}

}  // namespace

void add_run(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand(
      "run",
      "Do everything: a capture session becomes calibrated volumes of κ and μ, and a report.\n\n"
      "INPUT is a folder with session.json: calibrate, merge, fit, export, report. Or a folder "
      "with\n"
      "measurements.json from any rig or program: fit, export, report. RUN then holds "
      "calibration/,\n"
      "hdr/, measurements/, measurements_validate/, fit/ (volume.vdb, kappa_R.npy ... [mm],\n"
      "mu_R.npy ... [1/mm]), export/ and report.html (docs/formats.md).\n\n"
      "Each stage that is complete for the same inputs, options and program is skipped; killed at\n"
      "any moment and started again, the command goes on where it was and ends in the same bits. "
      "A\n"
      "RUN made from another input is refused.\n\n"
      "Held-out E = Σ(L' − L)²/ΣL² compares photographs under light that the fit never saw with\n"
      "what the volumes predict: below 1e-3, or close to what the photographs' noise alone makes,\n"
      "is good. Look at the report before you trust a volume.");
  auto options = std::make_shared<RunOptions>();
  command->add_option("input", options->input, "Session folder, or folder of measurements")
      ->required()
      ->type_name("INPUT");
  command->add_option("-o,--out", options->run, "Run folder; made if missing")
      ->required()
      ->type_name("RUN");
  command->add_flag("--force", options->force, "Do every stage again, replacing what RUN holds");
  add_follow_links(*command, options->follow_links);
  add_hdr_options(*command, options->hdr);
  add_fit_options(*command, options->fit);
  command->footer(
      "Exit code 3: the fit did not converge; everything is kept and marked in the report.\n"
      "With --json the last line is one object: sample, grid, camera_rms_px, projector_rms_px,\n"
      "holdout_E, kappa_mu_volume, report, seconds by stage, seconds_total, device, warnings.\n"
      "Example: kappamu run demo/session -o demo/run");
  command->callback([command, options, &globals] { run_run(*command, *options, globals); });
}

}  // namespace kappamu::app
