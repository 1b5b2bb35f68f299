#include "pipeline/stages/fit_evidence.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/records/run_record.h"

namespace kappamu::pipeline {

namespace {

std::size_t earlier_warnings(const std::filesystem::path& run) {
  std::size_t count = 0;
  if (const std::optional<RunRecord> record = read_run_record(run)) {
    for (const char* stage : {"calibrate", "merge"}) {
      const auto found = record->stages.find(stage);
      if (found != record->stages.end()) count += found->second.warnings.size();
    }
  }
  return count;
}

/// Share of the values that the mask allows.
double used_share(const SurfaceMeasurements& measured) {
  if (measured.mask.empty()) return 1.0;
  const auto left_out = std::count(measured.mask.begin(), measured.mask.end(), 0);
  return 1.0 - static_cast<double>(left_out) / static_cast<double>(measured.mask.size());
}

}  // namespace

FitRecord make_fit_record(const FitSummary& summary, const SurfaceMeasurements& fitted,
                          const ValidationChoice& validation,
                          const std::optional<calib::CalibrationResult>& calibration,
                          const std::filesystem::path& input) {
  FitEvidence evidence;
  std::vector<inverse::FitStatus> statuses;
  evidence.warnings = earlier_warnings(input) + (validation.warning ? 1 : 0);
  for (std::size_t c = 0; c < summary.channels.size(); ++c) {
    const inverse::FitReport& report = summary.reports[c];
    evidence.channels.push_back({summary.channels[c], report.status, report.chi2_per_value,
                                 report.model.systematic, report.shared});
    statuses.push_back(report.status);
    evidence.warnings += report.warnings.size();
  }
  evidence.used = used_share(fitted);
  evidence.front_lit = fitted.lit_is_seen();
  if (calibration) {
    evidence.camera_rms_px = calibration->camera.rms_px;
    evidence.projector_rms_px = calibration->projector.rms_px;
  }
  FitRecord record;
  record.status = overall_status(statuses);
  record.grid = {fitted.grid.nx, fitted.grid.ny, fitted.grid.nz};
  record.camera_rms_px = evidence.camera_rms_px;
  record.projector_rms_px = evidence.projector_rms_px;
  if (!summary.validation.empty()) {
    AppearanceError all;
    const std::size_t patterns = summary.validation.front().pattern_error.size();
    for (std::size_t m = 0; m < patterns; ++m) {
      AppearanceError& pattern = evidence.validation.emplace_back();
      for (const inverse::ValidationScore& score : summary.validation) {
        pattern.add(score.pattern_error[m]);
      }
      all.add(pattern);
      evidence.validation_names.push_back(validation.source ==
                                                  ValidationChoice::Source::fitted_input
                                              ? "pattern " + std::to_string(validation.patterns[m])
                                              : "validation pattern " + std::to_string(m));
    }
    record.validation_E = all.E();
    record.validation_noise_E = all.noise_E();
  }
  record.verdict = make_verdict(evidence);
  return record;
}

}  // namespace kappamu::pipeline
