#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/bench_command.h"
#include "bench/record.h"
#include "bench/validity.h"
#include "io/atomic_file.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  std::string out;
  bool quick = false;
};

void run_validity(const Options& options, Globals& globals) {
  bench::ValidityOptions settings =
      options.quick ? bench::quick_validity() : bench::ValidityOptions{};
  settings.device = globals.device;
  settings.seed = globals.seed;
  const std::filesystem::path out = pipeline::bench_folder(options.out);
  const auto progress = make_progress();
  const auto cases = bench::measure_validity(settings, *progress);
  const auto record = bench::validity_record(settings, cases);
  bench::write_record(record, out / "validity.json");
  io::write_text_atomically(out / "validity_table.inc", bench::validity_table(settings, cases));
  bench::draw_validity(cases, out / "validity.png");
  if (globals.json) {
    std::printf("%s\n", record.dump().c_str());
    return;
  }
  std::printf(
      "albedo  paths   reflected  transmitted   lit map   far map   (diffusion against "
      "Monte Carlo, %%; ~ within noise)\n");
  const auto cell = [](const bench::RelativeError& e) {
    std::printf("  %8.2f%c", 100.0 * e.value, e.resolved() ? ' ' : '~');
  };
  for (const auto& c : cases) {
    std::printf("%6g %6g ", c.albedo, c.mean_free_paths);
    for (const auto* e : {&c.reflected, &c.transmitted, &c.lit_map, &c.far_map}) cell(*e);
    std::printf("\n");
  }
  std::printf("%s\n", (out / "validity.png").c_str());
}

}  // namespace

void add_bench_validity(CLI::App& bench, Globals& globals) {
  auto* command = bench.add_subcommand(
      "validity",
      "Measure where diffusion can be trusted: its error against Monte Carlo over albedo and\n"
      "optical thickness (docs/validity.md).\n\n"
      "  kappamu bench validity -o out/            56 slabs, 10^6 photons each: a few minutes\n"
      "  kappamu bench validity --quick -o out/    9 slabs, 10^5 photons each: seconds\n\n"
      "Writes validity.json, validity.png (with validity.gp) and validity_table.inc, which\n"
      "forward/analytic/ holds a copy of for the program's own warnings.");
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder to write into")->required();
  command->add_flag("--quick", options->quick, "Fewer cases and photons");
  command->callback([options, &globals] { run_validity(*options, globals); });
}

}  // namespace kappamu::app
