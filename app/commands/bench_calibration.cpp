#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/bench_command.h"
#include "bench/record.h"
#include "bench/views.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct Options {
  std::string out;
  bool quick = false;
  double corner_noise_px = bench::ViewsOptions{}.corner_noise_px;
};

void run_calibration(const Options& options, Globals& globals) {
  bench::ViewsOptions settings = options.quick ? bench::quick_views() : bench::ViewsOptions{};
  settings.seed = globals.seed;
  settings.corner_noise_px = options.corner_noise_px;
  const std::filesystem::path out = pipeline::bench_folder(options.out);
  const auto progress = make_progress();
  const auto cases = bench::measure_views(settings, *progress);
  const auto record = bench::views_record(settings, cases);
  bench::write_record(record, out / "calibration.json");
  bench::draw_views(cases, out / "calibration-views.png");
  if (globals.json) {
    std::printf("%s\n", record.dump().c_str());
    return;
  }
  std::printf("views  refused   over the frame [px]    focal length [%%]\n");
  std::printf("                 error     stated      error     stated\n");
  for (const auto& c : cases) {
    std::printf("%5d  %7d  %8.3f  %9.3f  %9.4f  %9.4f\n", c.views, c.refused, c.error_px,
                c.predicted_px, 100.0 * c.focal_relative, 100.0 * c.focal_predicted);
  }
  std::printf("%s\n", (out / "calibration-views.png").c_str());
}

}  // namespace

void add_bench_calibration(CLI::App& bench, Globals& globals) {
  auto* command = bench.add_subcommand(
      "calibration",
      "Measure what a camera calibration is worth against the number of board views\n"
      "(docs/calibration.md): error of the projection at the sample, over the whole frame, and of\n"
      "the focal length, each against what the calibrations state themselves.\n\n"
      "  kappamu bench calibration -o out/            3 to 40 views, 60 runs each: minutes\n"
      "  kappamu bench calibration --quick -o out/    seconds\n\n"
      "Writes calibration.json and calibration-views.png (with calibration-views.gp).");
  auto options = std::make_shared<Options>();
  command->add_option("-o,--out", options->out, "Folder to write into")->required();
  command->add_flag("--quick", options->quick, "Fewer counts and runs");
  command
      ->add_option("--corner-noise", options->corner_noise_px,
                   "Standard deviation of a corner, per coordinate [px]: 0.1 is what real boards "
                   "leave, 0.0013 what rendered ones do")
      ->check(CLI::Range(1e-4, 10.0))
      ->capture_default_str();
  command->callback([options, &globals] { run_calibration(*options, globals); });
}

}  // namespace kappamu::app
