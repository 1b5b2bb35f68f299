// What the exports of renderer coefficients share.
#pragma once

#include "io/volume/volume_export.h"

namespace kappamu::io {

/// scattering_volumes() of each channel; one warning per channel with clamped voxels goes to
/// `result`.
std::vector<ScatteringVolumes> scattering_with_warnings(const VolumeSet& set, ExportResult& result);

/// The shortest text that reads back as the same number.
std::string number_text(double value);

}  // namespace kappamu::io
