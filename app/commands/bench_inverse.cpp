#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/bench_command.h"
#include "bench/inverse_bench.h"
#include "bench/inverse_samples.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  bench::InverseBenchOptions bench;
  std::string out;
  std::vector<std::string> sections;
  bool small = false;
  bool quick = false;
  bool draw_only = false;
};

void run(Options& options, const Globals& globals) {
  const auto progress = make_progress();
  options.bench.folder = pipeline::bench_folder(options.out);
  options.bench.device = globals.device;
  options.bench.seed = globals.seed;
  if (options.small) options.bench.size = bench::BenchSize::small;
  if (options.quick) options.bench.size = bench::BenchSize::quick;
  if (!options.draw_only) {
    for (const std::string& section :
         options.sections.empty() ? bench::inverse_sections() : options.sections) {
      bench::measure_inverse(section, options.bench, *progress);
    }
  }
  bench::draw_inverse(options.out);
  if (globals.json) {
    std::printf("%s\n", bench::inverse_summary(options.out).dump().c_str());
  } else {
    std::printf("records, charts and tables in %s\n", options.out.c_str());
  }
}

constexpr const char* manual =
    "What fits cost and how good their volumes are, under light they never saw.\n\n"
    "  kappamu bench inverse -o out/bench                      all sections, about half an hour\n"
    "  kappamu bench inverse -o out/bench --section scores     one\n"
    "  kappamu bench inverse -o out/bench --small              minutes, on smaller blocks\n"
    "  kappamu bench inverse -o out/bench --quick              toy blocks, 1 % noise alone\n\n"
    "SECTIONS. optimisers: E along the course of every way to fit, at noise 0, 0.3, 1 and 3 %.\n"
    "scores: the default over several truths and seeds, under eight bars either way and under\n"
    "4 x 4 patches, median and worst, and the error of kappa and mu by depth. embedded: the same\n"
    "with smaller boxes, none at a face. patterns: by the number of images, patches and bars,\n"
    "back-lit and front-lit. voxels: cost against the size of the block. montecarlo: data by\n"
    "transport instead of diffusion. samples: wax1, wax2, marble, stone at the paper's sizes,\n"
    "R, G and B (--sample NAME: one of them), a quarter of an hour.\n\n"
    "WHAT IS MEASURED. Truths are smooth random fields of contrast 4 with two boxes, solved on a\n"
    "grid twice as fine as the fitted one; data get Gaussian noise relative to each value, with a\n"
    "floor. E = sum (L' - L)^2 / sum L^2 of the exported volume, every voxel split 2x2x2 and\n"
    "nothing corrected, against noise-free truth under 8x8 patches, or single voxels, that the "
    "fit\n"
    "never saw. Solves are batched ones of all patterns on whatever grid, start included; work is\n"
    "their iterations times voxels over the fitted grid's voxels.\n\n"
    "OUTPUT in the folder of -o: inverse-<section>.json (raw), bench-inverse-<section>.png with "
    "the\n"
    "gnuplot script beside it, table-inverse-<section>.md. --json: sample, grid, channels, "
    "patterns,\n"
    "noise, optimiser, batched_solves, seconds, holdout_E, data_misfit_chi2, device, of the "
    "median\n"
    "truth at 1 % noise.";

}  // namespace

void add_bench_inverse(CLI::App& bench_command, Globals& globals) {
  auto* command = bench_command.add_subcommand("inverse", manual);
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder for records and charts; made if missing")
      ->required()
      ->type_name("OUT");
  command->add_option("--section", options->sections, "Measure this section alone; may be repeated")
      ->check(CLI::IsMember(bench::inverse_sections()))
      ->type_name("NAME");
  command
      ->add_option("--sample", options->bench.samples,
                   "Of section samples, measure this one alone; may be repeated")
      ->check(CLI::IsMember(bench::paper_samples()))
      ->type_name("NAME");
  auto* small = command->add_flag("--small", options->small, "Smaller blocks, minutes in all");
  command->add_flag("--quick", options->quick, "Toy blocks, seconds in all")->excludes(small);
  command->add_flag("--draw", options->draw_only, "Measure nothing; draw what the folder holds");
  command->footer(
      "WHEN NOT TO TRUST IT. Seconds on a machine that does anything else; anything of --quick.");
  command->callback([options, &globals] { run(*options, globals); });
}

}  // namespace kappamu::app
