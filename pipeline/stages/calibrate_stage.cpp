#include "pipeline/stages/calibrate_stage.h"

#include <algorithm>
#include <cstdio>

#include "calib/calibrate.h"
#include "calib/calibration_file.h"
#include "calib/light/stray_light.h"
#include "capture/radiance/chart_search.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;

namespace {

/// The session with the chart's place filled in where mcc finds it; calibrate() looks for it
/// otherwise.
capture::Session with_chart_place(capture::Session session) {
  auto& chart = session.calibration.colour_chart;
  if (chart && !chart->corners_px) {
    if (const auto place = capture::find_chart_place(session, chart->frames)) {
      chart->corners_px = place->corners_px;
    }
  }
  return session;
}

/// What the chart's dark patches tell of room light and flare, if it is worth a warning.
void warn_of_stray_light(calib::CalibrationResult& result, Progress& progress) {
  constexpr double worth_a_warning = 0.01;  // of white
  if (!result.chart) return;
  double worst = 0.0;
  for (std::size_t c = 0; c < result.chart->scale.size(); ++c) {
    worst = std::max(worst, calib::stray_light(*result.chart, c).value_or(0.0));
  }
  if (worst < worth_a_warning) return;
  char percent[16];
  std::snprintf(percent, sizeof percent, "%.1f", 100.0 * worst);
  result.warnings.push_back("stray light of " + std::string(percent) +
                            " % of white brightens the colour chart's dark patches: darken the "
                            "room and shade the lens.");
  progress.warn(result.warnings.back());
}

}  // namespace

void run_calibrate_stage(const capture::Session& session, const capture::HdrOptions& hdr,
                         const fs::path& output, Progress& progress) {
  calib::CalibrationResult result = calib::calibrate(with_chart_place(session), progress, hdr);
  warn_of_stray_light(result, progress);
  calib::save_calibration(output, result);
}

}  // namespace kappamu::pipeline
