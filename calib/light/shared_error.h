// Errors that neighbouring pixels share (SmoothError), measured: on what should be even, or equal,
// the part of the difference that noise does not explain, octave by octave.
#pragma once

#include <string>
#include <vector>

#include "calib/light/radiometry.h"
#include "capture/session/session.h"
#include "core/grid.h"
#include "core/surface_measurements.h"

namespace kappamu::calib {

/// Root mean square of an octave, mean of those from the face's width to four voxels, of what
/// `map.relative` has beyond its noise; 0 where noise explains all. NaN where less than half of the
/// face has a value.
double octave_error(const FaceMap& map);

struct SharedError {
  SmoothError error;
  std::string source;  ///< where both figures come from, one line
};

/// What the session states; else of all patterns the unevenness of the white target beyond a smooth
/// field, and of each the difference of patterns photographed twice, else of the target under
/// several values. Where these tell one, the other is in the proportion of the usual instrument;
/// where they tell nothing both are its own, 0.2 and 0.5 %. What pose and blur leave besides, which
/// no even target shows, is added: 0.01 % of both, lit and seen on one face 0.04 and 0.08 %.
SharedError shared_error(const capture::Session& session, const WhiteReference& white,
                         const SurfaceMeasurements& measurements);

}  // namespace kappamu::calib
