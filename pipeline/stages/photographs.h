// One stage of the work on photographs alone, without a session: what `kappamu merge` does with a
// bracket and `kappamu calibrate` with pictures of boards and Gray codes.
#pragma once

#include <filesystem>
#include <optional>

#include "calib/calibrate.h"
#include "capture/import/photograph_session.h"
#include "capture/radiance/merge.h"
#include "core/progress.h"

namespace kappamu::pipeline {

/// What lies in the folder of a merged bracket.
struct BracketSummary {
  std::size_t frames = 0, dark_frames = 0;
  double saturated_share = 0.0, dark_share = 0.0;  ///< of the values, in every frame
  double darkest = 0.0,
         brightest = 0.0;  ///< radiance of the values that are neither [full scales/s]
};

/// Merges a bracket into output/radiance.exr (hdr_file.h: radiance, variance, flags) and writes the
/// recovered response to output/response.yml. Throws InputError for photographs that cannot be
/// used.
BracketSummary merge_photographs(const capture::PhotographSource& source,
                                 capture::Encoding encoding, const capture::MergeOptions& hdr,
                                 const std::filesystem::path& output, Progress& progress);

/// Calibrates a camera, whose lens may be known, and, with a projector's size, a projector; writes
/// output/camera.yml, projector.yml and calibration.json (calibration_file.h).
calib::CalibrationResult calibrate_photographs(const capture::PhotographSource& source,
                                               const capture::Board& board,
                                               const std::optional<capture::Projector>& projector,
                                               const std::optional<calib::KnownLens>& known,
                                               const std::filesystem::path& output,
                                               Progress& progress);

}  // namespace kappamu::pipeline
