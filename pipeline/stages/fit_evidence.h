// What a finished fit's verdict is made of, gathered from the fit, its input and the run around it.
#pragma once

#include <filesystem>
#include <optional>

#include "calib/calibrate.h"
#include "core/surface_measurements.h"
#include "pipeline/records/fit_record.h"
#include "pipeline/stages/fit_stage.h"
#include "pipeline/stages/validation_choice.h"

namespace kappamu::pipeline {

/// `fitted`: the patterns that the fit saw before validation; `input`: the folder whose run.json,
/// if any, has the warnings of the stages before.
FitRecord make_fit_record(const FitSummary& summary, const SurfaceMeasurements& fitted,
                          const ValidationChoice& validation,
                          const std::optional<calib::CalibrationResult>& calibration,
                          const std::filesystem::path& input);

}  // namespace kappamu::pipeline
