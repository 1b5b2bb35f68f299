#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/bench_command.h"
#include "bench/record.h"
#include "bench/rig_needs.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  bench::RigNeedsOptions needs;
  std::string out;
  bool quick = false;
};

void run_rig(Options options, const Globals& globals) {
  bench::RigNeedsOptions& settings = options.needs;
  if (options.quick) {
    const bench::RigNeedsOptions quick = bench::quick_rig_needs();
    settings.views = quick.views;
    settings.exposures = quick.exposures;
    settings.rigs = quick.rigs;
  }
  settings.seed = globals.seed;
  if (globals.device != "auto") settings.device = globals.device;
  const std::filesystem::path out = pipeline::bench_folder(options.out);
  settings.folder = out / "sessions";
  const auto progress = make_progress();
  const bench::RigNeeds needs = bench::measure_rig_needs(settings, *progress);
  const auto record = bench::rig_needs_record(settings, needs);
  bench::write_record(record, out / "rig.json");
  bench::draw_rig_needs(needs, out / "rig-needs.png");
  if (globals.json) {
    std::printf("%s\n", record.dump().c_str());
    return;
  }
  std::printf(
      "The fit itself, under the true lenses: κ %.1f %%, μ %.0f %% off, E %.1e\n\n%s\n%s\n%s\n",
      100.0 * needs.best.kappa, 100.0 * needs.best.mu, needs.best.holdout_E,
      bench::views_table(needs).c_str(), bench::exposures_table(needs).c_str(),
      (out / "rig-needs.png").c_str());
}

}  // namespace

void add_bench_rig(CLI::App& bench, Globals& globals) {
  auto* command = bench.add_subcommand(
      "rig",
      "Measure which calibration views and exposures a rig needs for a given error of κ and μ\n"
      "(docs/calibration.md, docs/hdr.md): simulated rigs of the sample tiny, the change that\n"
      "corners of so many views, or stacks of so many exposures, bring into measurements, κ and "
      "μ;\n"
      "found by fitting again, and predicted from the calibration's joint covariance and the\n"
      "merge's variance.\n\n"
      "  kappamu bench rig -o out/            four rigs: six minutes of CPU\n"
      "  kappamu bench rig --quick -o out/    one rig, fewer counts: a minute\n\n"
      "Writes rig.json and rig-needs.png (with rig-needs.gp); the sessions stay in OUT/sessions\n"
      "and are used again.");
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder to write into")->required();
  command->add_flag("--quick", options->quick, "Fewer rigs and counts");
  command
      ->add_option("--corner-noise", options->needs.corner_noise_px,
                   "Deviation of a board's corner, per coordinate [camera px]")
      ->check(CLI::Range(1e-3, 1.0))
      ->capture_default_str();
  command->add_option("--rigs", options->needs.rigs, "Rigs, with seeds from --seed on")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->callback([options, &globals] { run_rig(*options, globals); });
}

}  // namespace kappamu::app
