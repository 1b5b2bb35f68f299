#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/bench_command.h"
#include "bench/record.h"
#include "bench/slabs.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  std::string data, out;
  bench::SlabOptions settings;
};

void run_slabs(Options options, Globals& globals) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(options.data)) {
    std::fprintf(stderr,
                 "kappamu: %s: no such folder, so nothing was measured; name the folder with "
                 "peer_iad.csv and its .rxt files by --data\n",
                 options.data.c_str());
    return;
  }
  const fs::path out = pipeline::bench_folder(options.out, {options.data});
  const auto progress = make_progress();
  options.settings.seed = globals.seed;
  const auto rows =
      bench::compare_slabs(bench::read_measured_slabs(options.data), options.settings, *progress);
  const auto record = bench::slab_record(options.settings, rows);
  bench::write_record(record, out / "slabs.json");
  bench::draw_slabs(rows, out / "slabs.png");
  if (globals.json) {
    std::printf("%s\n", record.dump().c_str());
    return;
  }
  std::printf(
      "median |predicted - measured|       diffusion        Monte Carlo\n"
      "file            rows   albedo         paths        M_R     M_T     M_R     M_T\n");
  for (const auto& s : bench::summarise(rows)) {
    std::printf("%-14s %5d   %.3f-%.3f  %6.2f-%-6.2f %.4f  %.4f  %.4f  %.4f\n", s.file.c_str(),
                s.rows, s.albedo_low, s.albedo_high, s.paths_low, s.paths_high, s.diffusion_r,
                s.diffusion_t, s.monte_carlo_r, s.monte_carlo_t);
  }
  std::printf("%s\n", (out / "slabs.png").c_str());
}

}  // namespace

void add_bench_slabs(CLI::App& bench, Globals& globals) {
  auto* command = bench.add_subcommand(
      "slabs",
      "Predict total reflectance and transmittance of measured slabs by diffusion and by Monte\n"
      "Carlo, from coefficients that inverse adding-doubling found (docs/validity.md).\n\n"
      "  kappamu bench slabs --data ../shared/data/slab-rt-iad -o out/\n\n"
      "DIR holds peer_iad.csv and the .rxt files of github.com/scottprahl/iad it was made from.\n"
      "Writes slabs.json and slabs.png (with slabs.gp).");
  auto options = std::make_shared<Options>();
  command->add_option("--data", options->data, "Folder of the measurements")->required();
  command->add_option("-o,--out", options->out, "Folder to write into")->required();
  command->add_option("--photons", options->settings.photons, "Per row (default 20000)")
      ->check(CLI::Range(100, 100000000));
  command
      ->add_option("--every", options->settings.every,
                   "Of long spectra, one row in so many (default 1: all)")
      ->check(CLI::PositiveNumber);
  command->callback([options, &globals] { run_slabs(*options, globals); });
}

}  // namespace kappamu::app
