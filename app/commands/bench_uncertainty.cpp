#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include "app/bench_command.h"
#include "bench/uncertainty_bench.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  bench::UncertaintyBenchOptions bench;
  std::string out;
  bool small = false;
};

void run(Options options, const Globals& globals) {
  const auto progress = make_progress();
  options.bench.folder = pipeline::bench_folder(options.out);
  options.bench.proof.device = globals.device;
  options.bench.proof.seed = globals.seed;
  if (options.small) {
    options.bench.proof.grid = {8, 8, 4, 0.5};
    options.bench.proof.side = 3;
  }
  bench::measure_uncertainty(options.bench, *progress);
  const std::string file =
      options.out + (globals.json ? "/uncertainty.json" : "/table-uncertainty.md");
  std::cout << std::ifstream(file).rdbuf();
}

}  // namespace

void add_bench_uncertainty(CLI::App& bench_command, Globals& globals) {
  auto* command = bench_command.add_subcommand(
      "uncertainty",
      "Prove the standard deviations of a fit by sampling, and weigh the ways to estimate them.\n\n"
      "  kappamu bench uncertainty -o out/bench            12 x 12 x 6 voxels, some minutes\n"
      "  kappamu bench uncertainty -o out/bench --small    8 x 8 x 4 voxels, under a minute\n\n"
      "A block is fitted to data from a grid twice as fine; its posterior is made of dense "
      "matrices.\n"
      "Then (a) data get fresh noise and the full objective is minimised again, with the same "
      "weight\n"
      "and grid correction: the spread of those fits over the predicted one; (b) truths are drawn\n"
      "from the prior, measured with noise in the linearised problem and estimated: the spread of\n"
      "the errors over the posterior's; (c) the estimate that `kappamu fit` makes and the best\n"
      "possible low-rank update of the prior, over the exact posterior, by batched solves.\n\n"
      "Ratios of standard deviations, as 5 % quantile, median and 95 % quantile over voxels. "
      "Sixty\n"
      "fits know a deviation to 9 %. Writes uncertainty.json, bench-uncertainty.png,\n"
      "bench-uncertainty-cost.png and table-uncertainty.md.");
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder to write into; made if missing")
      ->required()
      ->type_name("OUT");
  command->add_flag("--small", options->small, "A smaller block");
  command->add_option("--fits", options->bench.fits, "Fits to fresh noise")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command->add_option("--weight", options->bench.proof.weight, "Weight of the smoothing")
      ->capture_default_str();
  command->add_option("--noise", options->bench.proof.noise, "Relative to each datum")
      ->capture_default_str();
  command->callback([options, &globals] { run(*options, globals); });
}

}  // namespace kappamu::app
