// The end of the pipeline's first half: HDR pictures and calibration become SurfaceMeasurements.
#pragma once

#include <functional>
#include <string>

#include "calib/calibrate.h"
#include "capture/radiance/hdr.h"
#include "capture/session/session.h"
#include "core/numbers/region.h"
#include "core/progress.h"
#include "core/surface_measurements.h"

namespace kappamu::calib {

/// Gives the merged picture of a pattern by its id; called once per pattern, in the session's
/// order, so that pictures may be streamed.
using HdrSource = std::function<capture::HdrImage(const std::string& pattern_id)>;

/// What calibration leaves uncertain from voxel to voxel, added to the variance of every value.
/// Independent of the pixels' noise, which is propagated apart; what neighbours share (scale, pose,
/// response) is apart as well (light/shared_error.h). docs/calibration.md says where the figures
/// come from.
struct MeasureOptions {
  double relative_error = 0.001;     ///< standard deviation over value
  double rim_relative_error = 0.01;  ///< the same on the outermost ring of voxels
  /// Front-lit: voxels that receive more than this part of full white, and their neighbours, are
  /// left out, because the camera sees light reflected off their surface.
  double lit_threshold = 0.01;
  bool keep_lit = false;  ///< lit voxels are measured too, for physics that holds there
};

/// The part of the pictures that measure_surface() needs: the sample's surroundings.
Region measured_part(const capture::Session& session, const CalibrationResult& calibration);

/// Measurements of the session's patterns of one role, in the session's order: exitance of the seen
/// face and irradiance of the lit face. Values in units of the rig's white irradiance:
///   M = (signal / scale) / radiance_per_exitance(viewing angle of the voxel).
/// Their smooth_error is for the caller to state. Masked: voxels out of the picture, with a
/// saturated or missing pixel, and, front-lit, lit ones. Throws InputError if the session has no
/// pattern of that role, a pattern image has another size than the projector or is not grey, or the
/// projector misses a tenth of the lit face.
SurfaceMeasurements measure_surface(const capture::Session& session,
                                    const CalibrationResult& calibration, capture::PatternRole role,
                                    const HdrSource& hdr, Progress& progress,
                                    const MeasureOptions& options = {});

}  // namespace kappamu::calib
