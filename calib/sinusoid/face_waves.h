// Sinusoids among the patterns of surface measurements, found by the light itself, and the face's
// answer to them. With the irradiance of each voxel known, neither phases nor frequencies need to
// be stated: voxel by voxel, exitance over phases is a straight line of irradiance,
//
//     M = R(0) E0 + R(f) (E - E0),
//
// where E0 is the mean over the phases.
#pragma once

#include <cstdint>
#include <vector>

#include "calib/sinusoid/demodulate.h"
#include "core/image.h"
#include "core/surface_measurements.h"

namespace kappamu::calib {

/// Patterns of one sinusoid in three or more phases.
struct FaceWave {
  Carrier carrier;            ///< cycles per voxel, along u and v
  std::vector<int> patterns;  ///< numbers in the measurements
};

/// By rising frequency. Patterns of other light (bars, patches, even light) are passed over.
/// Throws InputError where a sinusoid has fewer than three phases.
std::vector<FaceWave> face_waves(const SurfaceMeasurements& measurements);

/// Exitance over incident irradiance, [v][u].
struct FaceAnswer {
  Image<float> even, wave;                      ///< R(0), R(f)
  Image<float> even_deviation, wave_deviation;  ///< standard, of the voxels' own noise
  Image<std::uint8_t> mask;                     ///< 1: valid
  double stripes = 0.0;  ///< what the line leaves, over the wave's amplitude: median of the voxels
};
FaceAnswer face_answer(const SurfaceMeasurements& measurements, std::size_t channel,
                       const FaceWave& wave);

}  // namespace kappamu::calib
