#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/command.h"
#include "app/options/fit_options.h"
#include "core/process_memory.h"
#include "pipeline/fit_folder.h"
#include "pipeline/records/model_json.h"
#include "pipeline/stages/continuation.h"
#include "pipeline/stages/fit_output.h"

namespace kappamu::app {

namespace {

using Json = nlohmann::ordered_json;

struct FitCommand {
  std::string input;
  std::string out;
  std::string validate;
  std::optional<std::string> continued;
  bool table = false;
  pipeline::FitStageOptions fit = pipeline::usual_options();
};

int adjoint_solves(const inverse::FitReport& report) {
  return report.history.empty() ? 0 : report.history.back().solves.adjoint;
}

Json to_json(const pipeline::FitSummary& summary) {
  Json channels = Json::array();
  for (std::size_t c = 0; c < summary.channels.size(); ++c) {
    const inverse::FitReport& r = summary.reports[c];
    channels.push_back({{"name", summary.channels[c]},
                        {"status", inverse::to_string(r.status)},
                        {"reason", r.reason},
                        {"model", pipeline::model_json(r.model)},
                        {"chi2_per_value", r.chi2_per_value},
                        {"warnings", r.warnings},
                        {"notes", summary.notes[c]},
                        {"adjoint_solves", adjoint_solves(r)},
                        {"seconds", r.seconds}});
    if (!summary.validation.empty()) {
      channels.back()["validation_E"] = summary.validation[c].error.E();
      channels.back()["validation_noise_E"] = summary.validation[c].error.noise_E();
      channels.back()["validation_chi2_per_value"] = summary.validation[c].chi2_per_value;
    }
    if (summary.uncertainty[c]) {
      channels.back()["uncertainty"] = pipeline::uncertainty_json(*summary.uncertainty[c]);
    }
  }
  Json object;
  pipeline::add_fit_record(summary.record, object);
  object["volume"] = summary.volume.string();
  object["device"] = summary.device;
  object["channels"] = channels;
  object["seconds"] = summary.seconds;
  object["memory_needed_bytes"] = summary.memory_needed;
  object["memory_peak_bytes"] = peak_memory();
  return object;
}

void print_table(const pipeline::FitSummary& summary) {
  for (std::size_t c = 0; c < summary.channels.size(); ++c) {
    const inverse::FitReport& r = summary.reports[c];
    std::printf("%-5s chi2 per value %-8.3g %4d adjoint solves  %6.1f s",
                summary.channels[c].c_str(), r.chi2_per_value, adjoint_solves(r), r.seconds);
    if (!summary.validation.empty()) {
      const inverse::ValidationScore& h = summary.validation[c];
      std::printf("  validation E %.2e (noise %.1e)", h.error.E(), h.error.noise_E());
    }
    std::printf("  %s: %s\n      model %s: %s\n", inverse::to_string(r.status).c_str(),
                r.reason.c_str(), pipeline::short_name(r.model).c_str(), r.model.reason.c_str());
    for (const std::string& note : summary.notes[c]) std::printf("      %s\n", note.c_str());
    if (summary.uncertainty[c]) {
      std::printf("      %s\n", summary.uncertainty[c]->sentence.c_str());
    }
  }
  std::printf("%s  (memory: %s, %s expected)\n", summary.volume.c_str(),
              gigabytes(peak_memory()).c_str(), gigabytes(summary.memory_needed).c_str());
  std::printf("%s\n", summary.record.verdict.sentence.c_str());
}

void run_fit(const CLI::App& app, FitCommand& command, Globals& globals) {
  if (command.table) {
    std::printf("%s", pipeline::options_page().c_str());
    return;
  }
  const auto progress = make_progress();
  if (!command.continued && command.input.empty()) throw CLI::RequiredError("INPUT");
  if (!command.continued && command.out.empty()) throw CLI::RequiredError("--out");
  take_globals(app, globals, command.fit);
  pipeline::FitStageOptions options = pipeline::resolve(command.fit);
  if (!command.validate.empty()) options.validate = command.validate;
  const pipeline::FitSummary summary =
      pipeline::fit_folder({command.input, command.out, command.continued}, options, *progress);
  if (globals.json) {
    print_json(to_json(summary));
  } else {
    print_table(summary);
  }
  globals.exit_code = summary.record.verdict.exit_code();
}

}  // namespace

void add_fit(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("fit",
                         R"(Find the volumes of κ and μ that explain surface measurements.

INPUT is a folder with measurements.json (docs/formats.md) from any rig or program, or a run
that `kappamu merge` filled. Each channel is fitted on its own: the best homogeneous block
first, then even layers, and where the data reject both a volume, coarse grid to fine, the
smoothing lowered until the residuals are as large as the measurements' own noise.

Writes OUT/kappa_<channel>.npy [mm] and mu_<channel>.npy [1/mm], float32 [z][y][x],
std_kappa_<channel>.npy, std_mu_<channel>.npy, resolution_kappa_<channel>.npy,
resolution_mu_<channel>.npy, correlation_<channel>.npy, sensitivity_<channel>.npy,
prediction.npy, prediction_validate.npy, volume.vdb and fit.json. Where no patterns were
captured for validation, one of every 16 is kept out of the fit (--hold-out) and gives the
validation error E. Then these patterns join and the last weight is minimised once more: E
is of the volumes before that, in OUT/validated. Killed at any moment and started again
with the same command it goes on where it was and ends in the same volumes.

Reading the result: chi2 per value near 1 means that the volumes explain the data to their
stated noise; well above 1, variances, calibration or the diffusion model do not hold. What
counts is E = Σ(L' − L)²/ΣL² of validation patterns, the error under light the fit never
saw, beside the part of it that those patterns' own noise makes. Light at steady state does
not determine deep voxels: the standard deviations std_kappa and std_mu, and the sentence that
goes with them, say how far κ and μ can be trusted, and over what width, since a voxel's
value is that of its surroundings; where resolution is near 0 they are the smoothing's
choice.)");
  auto options = std::make_shared<FitCommand>();
  // First of all: options given beside it are set after it and so prevail.
  command
      ->add_option_function<std::string>(
          "--continue",
          [options](const std::string& run) {
            options->continued = run;
            pipeline::FinishedFit(run).set_options(options->fit);
          },
          "Go on from the volumes of a finished fit, with its options and INPUT where none are "
          "given here; OUT is then RUN/fit_continued, or <fit>_continued beside a fit's folder, "
          "unless given")
      ->type_name("RUN");
  command
      ->add_option("input", options->input,
                   "Folder of measurements, or run folder; required without --continue")
      ->type_name("INPUT");
  command
      ->add_option("-o,--out", options->out,
                   "Folder for the results; made if missing; required without --continue")
      ->type_name("OUT");
  command
      ->add_option("--validate", options->validate,
                   "Measurements of validation patterns to predict and score (default: "
                   "INPUT/measurements_validate)")
      ->type_name("FOLDER");
  command->add_flag("--restart", options->fit.restart, "Ignore the checkpoints in OUT");
  command->add_flag("--options-table", options->table)->group("");
  add_fit_options(*command, options->fit);
  command->footer(
      R"(Exit code 3: a channel ran out of steps, its data are not explained to their noise (chi2
per value above 1.5, in all or in an octave of the errors that pixels share; or the light is
predicted more than two of its stated errors off), or the verdict is red; the volumes are
kept, with the verdict, in fit.json.
Examples: kappamu fit demo/run -o demo/run/fit
          kappamu fit --continue demo/run --regulariser h1 --lambda 30)");
  command->callback([command, options, &globals] { run_fit(*command, *options, globals); });
}

}  // namespace kappamu::app
