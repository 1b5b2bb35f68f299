// Calibration shots to calibration files: what `kappamu calibrate` and the calibrate stage of
// `kappamu run` share.
#pragma once

#include <filesystem>

#include "capture/radiance/merge.h"
#include "capture/session/session.h"
#include "core/progress.h"

namespace kappamu::pipeline {

/// Calibrates and writes into `output`: camera.yml, projector.yml, pose.yml, response.yml,
/// radiometry.yml and calibration.json (residuals by view, warnings). The folder appears complete
/// or not at all. Throws InputError for shots that cannot be used.
void run_calibrate_stage(const capture::Session& session, const capture::MergeOptions& hdr,
                         const std::filesystem::path& output, Progress& progress);

}  // namespace kappamu::pipeline
