// Which projector pixel each camera pixel sees, from phase-shifted sinusoids of several periods
// (multi-frequency temporal unwrapping) or of one period beside a Gray code.
#pragma once

#include <optional>
#include <vector>

#include "calib/projector/projector_map.h"
#include "capture/session/session.h"

namespace kappamu::calib {

/// The frames of one capture::PhaseShift, grey and of equal size, linear in light; two are held at
/// a time.
struct PhaseFrames {
  capture::PhaseShift::Along along = capture::PhaseShift::Along::columns;
  double period_px = 0.0;
  std::size_t count = 0;
  FrameSource frames;
};

/// From I_n = a + b cos(φ - 2πn/N): φ = atan2(Σ I_n sin 2πn/N, Σ I_n cos 2πn/N), which is u = φ
/// period/2π but for whole periods. These come from the next longer period, the longest of which
/// spans the projector's frame or is put in its place by `coarse`, a Gray code's map. A pixel is
/// legible where in every set b exceeds 2 % of the brightest a + b, no step is taken that is nearer
/// than an eighth of a period to the next one, and the place lies in the projector's frame. quality
/// is the smallest b/a.
ProjectorMap decode_phase_shift(std::vector<PhaseFrames> sets, const capture::Projector& projector,
                                const std::optional<ProjectorMap>& coarse = std::nullopt);

}  // namespace kappamu::calib
