// Exposure stacks to HDR images to surface measurements: what `kappamu merge` and the merge stage
// of `kappamu run` share.
#pragma once

#include <filesystem>

#include "capture/radiance/merge.h"
#include "capture/session/session.h"
#include "core/progress.h"

namespace kappamu::pipeline {

/// Merges every pattern into run/hdr/<pattern>.exr, several at once; files that are there already
/// are kept (an interrupted merge goes on). With run/calibration, uses its response and writes
/// run/measurements and, where the session has validate patterns, run/measurements_validate;
/// without, the response is recovered from the session. Frames that were corrected are warned of.
/// Throws InputError for frames that cannot be used.
void run_merge_stage(const capture::Session& session, const capture::HdrOptions& hdr,
                     const std::filesystem::path& run, Progress& progress);

}  // namespace kappamu::pipeline
