#include "pipeline/stages/calibrate_stage.h"

#include <algorithm>

#include "calib/calibrate.h"
#include "calib/calibration_file.h"
#include "calib/light/stray_light.h"
#include "core/memory/kept_blocks.h"
#include "core/shown_text.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;

namespace {

/// What the chart's dark patches tell of room light and flare, if it is worth a warning.
void warn_of_stray_light(calib::CalibrationResult& result, Progress& progress) {
  constexpr double worth_a_warning = 0.01;  // of white
  if (!result.chart) return;
  double worst = 0.0;
  for (std::size_t c = 0; c < result.chart->scale.size(); ++c) {
    worst = std::max(worst, calib::stray_light(*result.chart, c).value_or(0.0));
  }
  if (worst < worth_a_warning) return;
  result.warnings.push_back("stray light of " + shown_number(100.0 * worst, "%.1f") +
                            " % of white brightens the colour chart's dark patches: darken the "
                            "room and shade the lens.");
  progress.warn(result.warnings.back());
}

}  // namespace

void run_calibrate_stage(const capture::Session& session, const capture::MergeOptions& hdr,
                         const fs::path& output, Progress& progress) {
  const KeepsBlocks keeps;  // of one photograph for the next
  calib::CalibrationResult result = calib::calibrate(session, progress, hdr);
  warn_of_stray_light(result, progress);
  calib::save_calibration(output, result);
}

}  // namespace kappamu::pipeline
