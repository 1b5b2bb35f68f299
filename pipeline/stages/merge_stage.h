// Exposure stacks to HDR images to surface measurements: what `kappamu merge` and the merge stage
// of `kappamu run` share.
#pragma once

#include <filesystem>
#include <optional>

#include "calib/light/shared_error.h"
#include "calib/measure.h"
#include "capture/radiance/merge.h"
#include "capture/session/session.h"
#include "core/progress.h"
#include "pipeline/records/fingerprint.h"

namespace kappamu::pipeline {

/// Merges every pattern into output/hdr/<pattern>.exr, several at once; files that are there
/// already are kept (an interrupted merge goes on). With the folder of a calibration, merges what
/// shows the sample and its surroundings alone, uses the calibration's response, and writes
/// output/measurements and, where the session has validate patterns, output/measurements_validate;
/// without, the response is recovered from the session. Frames that were corrected are warned of.
/// `written` takes the fingerprints of the images that were made. Returns the errors that pixels of
/// the fit's patterns share, where surfaces were measured. Throws InputError for frames that cannot
/// be used.
std::optional<calib::SharedError> run_merge_stage(
    const capture::Session& session, capture::MergeOptions hdr,
    const std::optional<std::filesystem::path>& calibration, const std::filesystem::path& output,
    Progress& progress, const calib::MeasureOptions& options = {},
    KnownFingerprints* written = nullptr);

}  // namespace kappamu::pipeline
