#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "pipeline/chart_photograph.h"
#include "pipeline/output_folder.h"

namespace kappamu::app {

namespace {

struct ChartArguments {
  std::string photograph;
  std::string out;
  std::vector<double> corners;
  bool linear = false;
};

void run_chart(const ChartArguments& arguments, const Globals& globals) {
  std::optional<pipeline::ChartCorners> corners;
  if (!arguments.corners.empty()) {
    corners.emplace();
    for (std::size_t i = 0; i < 8; ++i) (*corners)[i / 2][i % 2] = arguments.corners[i];
  }
  pipeline::OutputFolder out(arguments.out, "chart", {arguments.photograph},
                             {"chart.csv", "chart.png"});
  const pipeline::ChartPhotograph chart = pipeline::measure_chart_photograph(
      arguments.photograph,
      arguments.linear ? capture::Encoding::linear : capture::Encoding::response, corners,
      out.partial());
  out.commit();
  if (globals.json) {
    nlohmann::json patches = nlohmann::json::array();
    for (const pipeline::ChartPatchMeans& patch : chart.patches) {
      patches.push_back({{"name", patch.name},
                         {"centre_px", patch.centre_px},
                         {"mean", patch.mean},
                         {"deviation", patch.deviation},
                         {"pixels", patch.pixels},
                         {"saturated", patch.saturated}});
    }
    print_json({{"chart", arguments.out},
                {"outlines", chart.outlines},
                {"neutral_slope", chart.neutral_slope},
                {"patches", patches}});
    return;
  }
  std::printf("%-14s %9s %9s %9s  %s\n", "patch", "R", "G", "B", "deviation R, G, B");
  for (const pipeline::ChartPatchMeans& patch : chart.patches) {
    std::printf("%-14s %9.1f %9.1f %9.1f  %.1f %.1f %.1f%s\n", patch.name.c_str(), patch.mean[0],
                patch.mean[1], patch.mean[2], patch.deviation[0], patch.deviation[1],
                patch.deviation[2], patch.saturated > 0 ? "  saturated" : "");
  }
  std::printf("outlines seen   %d of 24\n", chart.outlines);
  std::printf(
      "neutrals        ln code over ln reflectance %.2f %.2f %.2f (1: proportional to light)\n",
      chart.neutral_slope[0], chart.neutral_slope[1], chart.neutral_slope[2]);
  std::printf("%s/chart.png\n%s/chart.csv\n", arguments.out.c_str(), arguments.out.c_str());
}

}  // namespace

void add_chart(CLI::App& app, Globals& globals) {
  auto* command = app.add_subcommand("chart",
                                     R"(Measure a ColorChecker Classic in one photograph.

Finds the chart in any turn and prints mean code and standard deviation of the middle half
of its 24 patches, and how code grows with reflectance along the neutrals. OUT/chart.png
shows what was measured: look whether each outline lies within its patch. OUT/chart.csv has
the numbers. Where the chart is not recognised, --corners gives it.)");
  auto arguments = std::make_shared<ChartArguments>();
  command->add_option("photograph", arguments->photograph, "RAW, PNG, TIFF, JPEG or EXR")
      ->required();
  add_out(*command, arguments->out, "Folder of chart.png and chart.csv");
  command
      ->add_option("--corners", arguments->corners,
                   "Centres x y [px] of the dark skin, bluish green, black and white patches")
      ->expected(8);
  command->add_flag("--linear", arguments->linear,
                    "PNG or TIFF is linear in light; otherwise behind an unknown response");
  command->footer("Example: kappamu chart colorchart.dng -o chart");
  command->callback([arguments, &globals] { run_chart(*arguments, globals); });
}

}  // namespace kappamu::app
