#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/bench_command.h"
#include "bench/forward_bench.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  bench::ForwardBenchOptions bench;
  std::string out;
  std::vector<std::string> sections;
  bool no_peers = false;
  bool draw_only = false;
};

void run(Options& options, const Globals& globals) {
  const auto progress = make_progress();
  options.bench.folder = pipeline::bench_folder(options.out);
  options.bench.device = globals.device;
  options.bench.peers = !options.no_peers;
  if (!options.draw_only) {
    for (const std::string& section :
         options.sections.empty() ? bench::forward_sections() : options.sections) {
      bench::measure_forward(section, options.bench, *progress);
    }
  }
  bench::draw_forward(options.out);
  if (globals.json) {
    std::printf("%s\n", bench::forward_summary(options.out).dump().c_str());
  } else {
    std::printf("records, charts and tables in %s\n", options.out.c_str());
  }
}

constexpr const char* manual =
    "Time and true error of every method that solves the diffusion equation.\n\n"
    "  kappamu bench forward -o out/bench                    all sections, about half an hour\n"
    "  kappamu bench forward -o out/bench --section peers    one, merged with what is there\n"
    "  kappamu bench forward -o out/bench --quick            seconds, on toy grids\n\n"
    "SECTIONS. headline: 256x256x20 voxels, 16 light patterns, kappa of contrast 10 with\n"
    "inclusions at x100 and /100; our solver in both precisions, the serial reference, the\n"
    "papers' methods. kernels: each kernel of our solve there, its seconds (timed by the device)\n"
    "and the bytes it must move. peers: the same problem by hypre, PETSc and Eigen (those built;\n"
    "install with scripts/setup.sh --peers), two ranks under mpirun, beside ours. relaxation: a\n"
    "minute of the papers' relaxation on it. grids: other grids and contrasts. scaling: cubes of\n"
    "32 to 256 voxels a side. iterations: contrast 1 to 1e6 of four figures of kappa on cubes.\n\n"
    "WHAT IS MEASURED. seconds_per_rhs: median over repetitions of the solve of all patterns from\n"
    "zero, divided by their number, plus the set-up that a change of kappa and mu asks for, "
    "shared\n"
    "by the 16 patterns on every side. Peers' set-up leaves out the assembly of their matrix, and\n"
    "each runs with the best of a few settings, named in the record. true_error: ||phi - phi*|| /\n"
    "||phi*|| of the worst pattern, phi* converged in double to a residual of 1e-13, for all "
    "sides\n"
    "alike; the papers' methods show exitance only and are judged by the maps of all six faces\n"
    "(\"maps\" in legends). ratio: the peer's time over ours at equal true error, interpolated\n"
    "between tolerances on logarithmic axes.\n\n"
    "OUTPUT in the folder of -o: forward-<section>.json (raw), bench-<section>.png with the\n"
    "gnuplot script beside it (no picture of kernels), table-<section>.md. --json: grid, "
    "patterns,\n"
    "contrast, method, precision, iterations, seconds_per_rhs, true_error, bandwidth_fraction\n"
    "(bytes the whole solve must move over seconds times measured copy bandwidth), peers with\n"
    "ratio, fastest_peer and fastest_peer_ratio among them, relaxation (ratio at a true error of\n"
    "1e-2, or a lower bound), kernels (finest_bandwidth_fraction, and of each kernel).";

constexpr const char* manual_end =
    "WHEN NOT TO TRUST IT. On a machine that does anything else, or in --quick mode: toy grids "
    "fit\n"
    "into caches.";

}  // namespace

void add_bench_forward(CLI::App& bench_command, Globals& globals) {
  auto* command = bench_command.add_subcommand("forward", manual);
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder for records and charts; made if missing")
      ->required()
      ->type_name("OUT");
  command->add_option("--section", options->sections, "Measure this section alone; may be repeated")
      ->check(CLI::IsMember(bench::forward_sections()))
      ->type_name("NAME");
  command->add_option("--repetitions", options->bench.repetitions, "Median over these (default 3)")
      ->check(CLI::Range(1, 100));
  command->add_flag("--quick", options->bench.quick, "Toy grids, seconds in all");
  command->add_flag("--no-peers", options->no_peers, "Leave out hypre, PETSc and Eigen");
  command->add_flag("--draw", options->draw_only, "Measure nothing; draw what the folder holds");
  command->footer(manual_end);
  command->callback([options, &globals] { run(*options, globals); });
}

}  // namespace kappamu::app
