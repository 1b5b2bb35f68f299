// Diffuse reflectance of a sample's surface ([W] 6.1): what its lit face sends back under even
// light beyond what its fitted volume scatters there. Patterns that light the face part by part
// count together as even light.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/rigid.h"
#include "core/surface_measurements.h"

namespace kappamu::pipeline {

struct SurfaceReflectance {
  struct Channel {
    std::string name;
    double mean = 0.0;      ///< over the measured pixels, before negative ones are set to 0
    double noise = 0.0;     ///< standard error of a pixel by the pictures' variances, mean
    double negative = 0.0;  ///< share of the measured pixels that were set to 0
  };
  Face face = Face::z_minus;
  FaceShape shape;
  double measured = 0.0;     ///< share of the face's pixels; the others have the channel's mean
  std::vector<float> value;  ///< [channel][v][u]
  std::vector<Channel> channels;
};

/// `prediction` [channel][M][v][u] of the `channels` (their numbers among those measured) by the
/// fitted volume; `camera_from_sample` of the station that sees the lit face, without which the
/// camera looks along the normal. None where the lit face is not seen, where its pictures together
/// do not light it evenly, or where less than half of it is measured (lit pixels are saturated).
std::optional<SurfaceReflectance> surface_reflectance(
    const SurfaceMeasurements& measurements, std::span<const int> channels,
    std::span<const float> prediction, const std::optional<Rigid>& camera_from_sample);

/// reflectance_z-.exr
inline std::string reflectance_name(Face face) {
  return "reflectance_" + to_string(face) + ".exr";
}
/// Writes reflectance_name() [row from the largest v][u] into the folder, R, G, B or one
/// channel, and returns its name. Throws InputError for other numbers of channels.
std::string write_surface_reflectance(const std::filesystem::path& folder,
                                      const SurfaceReflectance& reflectance);

}  // namespace kappamu::pipeline
