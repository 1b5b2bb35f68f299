// The figures of rig_needs.h as a record, tables and a chart.
#include <array>
#include <nlohmann/json.hpp>

#include "bench/chart.h"
#include "bench/record.h"
#include "bench/rig_needs.h"
#include "bench/text.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const RigCase& c) {
  return {{"boards", c.views.boards},
          {"planes", c.views.planes},
          {"exposures", c.exposures},
          {"refused", c.refused},
          {"camera_px", c.camera_px},
          {"projector_px", c.projector_px},
          {"turn_degrees", c.turn_degrees},
          {"scale_relative", c.scale},
          {"value_relative", c.value},
          {"log_kappa", c.kappa},
          {"log_mu", c.mu},
          {"log_kappa_predicted", c.kappa_predicted},
          {"log_mu_predicted", c.mu_predicted},
          {"holdout_E", c.holdout_E}};
}

Chart chart(const std::vector<RigCase>& cases, const std::string& title, const std::string& x_label,
            double (*x)(const RigCase&)) {
  const auto series = [&](const std::string& label, double RigCase::*value, Series::Style style,
                          int colour) {
    Series one{label, {}, {}, {}, style, colour};
    for (const RigCase& c : cases) {
      one.x.push_back(x(c));
      one.y.push_back(100.0 * c.*value);
    }
    return one;
  };
  Chart chart;
  chart.title = title;
  chart.x_label = x_label;
  chart.y_label = "change of the median voxel [%]";
  chart.log_y = true;
  chart.legend = "inside right top";
  constexpr auto found = Series::Style::line_and_points;
  constexpr auto predicted = Series::Style::dashes;
  chart.series = {series("μ, found", &RigCase::mu, found, 2),
                  series("μ, predicted", &RigCase::mu_predicted, predicted, 2),
                  series("κ, found", &RigCase::kappa, found, 1),
                  series("κ, predicted", &RigCase::kappa_predicted, predicted, 1)};
  return chart;
}

/// Two digits that tell.
std::string percent(double share) {
  const double value = 100.0 * share;
  return text(value < 0.995 ? "%.2f %%" : value < 9.95 ? "%.1f %%" : "%.0f %%", value);
}

std::string changes(const RigCase& c) {
  return percent(c.value) + " | " + percent(c.kappa) + " | " + percent(c.kappa_predicted) + " | " +
         percent(c.mu) + " | " + percent(c.mu_predicted) + " | " + text("%.1e |\n", c.holdout_E);
}

constexpr const char* changes_header =
    "a measurement | κ | predicted | μ | predicted | held-out E |\n";

}  // namespace

Json rig_needs_record(const RigNeedsOptions& options, const RigNeeds& needs) {
  Json record = record_header("rig", options.device);
  record["sample"] = "tiny";
  record["channel"] = "G";
  record["rigs"] = options.rigs;
  record["draws"] = options.draws;
  record["corner_noise_px"] = options.corner_noise_px;
  record["seed"] = options.seed;
  record["best"] = to_json(needs.best);
  for (const RigCase& c : needs.views) record["views"].push_back(to_json(c));
  for (const RigCase& c : needs.exposures) record["exposures"].push_back(to_json(c));
  return record;
}

std::string views_table(const RigNeeds& needs) {
  std::string table =
      std::string(
          "| boards, planes | refused | seen face [camera px] | lit face [projector px] | "
          "turn [degrees] | ") +
      changes_header + "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const RigCase& c : needs.views) {
    table += text("| %d, %d | %d | %.2f | %.2f | %.2f | ", c.views.boards, c.views.planes,
                  c.refused, c.camera_px, c.projector_px, c.turn_degrees) +
             changes(c);
  }
  return table;
}

std::string exposures_table(const RigNeeds& needs) {
  std::string table = std::string("| exposures | scale | ") + changes_header +
                      "|---|---|---|---|---|---|---|---|\n";
  for (const RigCase& c : needs.exposures) {
    table += text("| %d | ", c.exposures) + percent(c.scale) + " | " + changes(c);
  }
  return table;
}

void draw_rig_needs(const RigNeeds& needs, const std::filesystem::path& png) {
  const std::array<Chart, 2> charts{
      chart(needs.views, "calibration views", "board views",
            [](const RigCase& c) { return static_cast<double>(c.views.boards); }),
      chart(needs.exposures, "exposures", "exposures of a pattern",
            [](const RigCase& c) { return static_cast<double>(c.exposures); })};
  draw(charts, png, 2, 620, 420);
}

}  // namespace kappamu::bench
