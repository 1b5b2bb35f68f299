#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/bench_command.h"
#include "bench/hdr_error.h"
#include "bench/record.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  std::string out;
  bool frames = false;
  bench::HdrErrorOptions settings;
};

void run_hdr(Options options, Globals& globals) {
  options.settings.seed = globals.seed;
  const std::filesystem::path out = pipeline::bench_folder(options.out);
  if (options.frames) options.settings.frames = out / "frames";
  const auto progress = make_progress();
  const auto rows = bench::compare_hdr_merges(options.settings, *progress);
  const auto record = bench::hdr_error_record(options.settings, rows);
  bench::write_record(record, out / "hdr.json");
  bench::draw_hdr_errors(rows, out / "hdr.png");
  if (globals.json) {
    std::printf("%s\n", record.dump().c_str());
    return;
  }
  std::printf("exposures  method                     error  darkest decade  CPU time\n");
  for (const auto& row : rows) {
    std::printf("%9d  %-24s %6.2f %%  %12.2f %%  %6.1f ms\n", row.exposures, row.method.c_str(),
                100.0 * row.relative_rms, 100.0 * row.dark_rms, 1e3 * row.seconds);
  }
  std::printf("%s\n", (out / "hdr.png").c_str());
}

}  // namespace

void add_bench_hdr(CLI::App& bench, Globals& globals) {
  auto* command = bench.add_subcommand(
      "hdr",
      "Measure the error of merged radiance and the merge's CPU time against the number of\n"
      "exposures, ours and the papers' weights beside OpenCV's merges (docs/hdr.md).\n\n"
      "  kappamu bench hdr -o out/\n\n"
      "A simulated eight-bit camera; every method gets its true response. Writes hdr.json and\n"
      "hdr.png (with hdr.gp).");
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder to write into")->required();
  command->add_option("--width", options->settings.width, "Of the frames [px]")
      ->check(CLI::Range(16, 10000))
      ->capture_default_str();
  command->add_option("--height", options->settings.height, "Of the frames [px]")
      ->check(CLI::Range(16, 10000))
      ->capture_default_str();
  command->add_option("--repetitions", options->settings.repetitions, "Merges timed")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_flag("--frames", options->frames,
                    "Also write frames/ with what other programs need to merge the same "
                    "(scripts/referees/hdr_peers.py)");
  command->callback([options, &globals] { run_hdr(*options, globals); });
}

}  // namespace kappamu::app
