// Which numbers are taken for those of a material, its voxels and its light.
#pragma once

#include <string>

namespace kappamu {

/// κ [mm] lies between the two, μ [1/mm] below the second. Beyond, squares leave the range of
/// floats, and light that scatters 1e9 times in a millimetre is followed for ever.
inline constexpr double least_kappa = 1e-9, most_coefficient = 1e9;

/// Edge of a voxel [mm]: beyond, areas and volumes of voxels leave the range of floats.
inline constexpr double least_voxel_mm = 1e-6, most_voxel_mm = 1e6;

/// Largest irradiance of all patterns, in the user's unit: light a million times dimmer and
/// brighter is still a float.
inline constexpr double least_light = 1e-20, most_light = 1e20;

/// Throw InputError "<source>: ..." beyond these bounds. Light that is zero everywhere passes.
void require_usual_voxel(double voxel_mm, const std::string& source);
void require_usual_light(double brightest, const std::string& source);

}  // namespace kappamu
