// A material's field as voxels over an object's box, which models take.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "io/volume/volume_set.h"
#include "render/material/material_field.h"

namespace kappamu::render {

struct Baked {
  io::VolumeSet set;          ///< over the object's box: R, G, B, or one channel for all three
  Eigen::Vector3d corner_mm;  ///< of the set's own frame, in the object's
};

inline constexpr double most_baked_voxels = 4e6;
/// κ and μ of three channels in double precision.
inline constexpr double bytes_per_baked_voxel = 6.0 * sizeof(double);

/// Voxels have the field's detail as their edge, or a larger one where the box would have more than
/// `most_baked_voxels`; a warning then says so. Throws InputError where memory is short.
Baked baked(const MaterialField& field, const TriangleMesh& mesh,
            std::vector<std::string>& warnings);

}  // namespace kappamu::render
