// Maps from a capture session under sinusoids, or from surface measurements of one: no phantom, the
// session's white target is the scale, and its calibration tells where each voxel of the face lies
// and what light falls there.
#pragma once

#include <filesystem>
#include <optional>

#include "capture/session/session.h"
#include "core/progress.h"
#include "core/surface_measurements.h"
#include "pipeline/records/sfdi_maps.h"
#include "pipeline/sfdi/sfdi_file.h"

namespace kappamu::pipeline::sfdi {

/// What measurements do not say of the medium; index and thickness are the sample's.
struct Scattering {
  double anisotropy = 0.9;  ///< g
  std::optional<double> anisotropy_deviation, index_deviation;
};

struct SessionMaps {
  Maps maps;
  Description description;  ///< as sfdi.json would state it
};

/// The channels' maps on the voxels of the seen face. Throws InputError naming `source` unless one
/// face is lit and seen under sinusoids.
SessionMaps maps_of_measurements(const SurfaceMeasurements& measurements,
                                 const Scattering& scattering, const std::string& source);

/// Calibrates the session and merges its pictures with lit pixels kept, into `output`
/// (calibration, hdr, measurements), and maps the patterns for the fit.
SessionMaps maps_of_session(const capture::Session& session, const Scattering& scattering,
                            const std::filesystem::path& output, Progress& progress);

}  // namespace kappamu::pipeline::sfdi
