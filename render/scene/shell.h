// A measured block wrapped round an object ([W] 5.2): its layers lie below the surface as they lay
// below the block's face z+ (a shell map, Porumbescu et al. 2005), the block mirrored again and
// again along the planes of the object's axes, blended by the normal, so that the pattern goes on
// all round. Below the block's last layer its values there are interpolated inwards by mean-value
// coordinates (Ju et al. 2005), positive ones alone, so that no coefficient leaves the block's
// range.
#pragma once

#include "core/mesh/polycube.h"
#include "core/mesh/triangle_mesh.h"
#include "io/volume/volume_set.h"

namespace kappamu::render {

struct Wrapped {
  io::VolumeSet set;          ///< over the object's box
  Eigen::Vector3d corner_mm;  ///< of the set's own frame, in the object's
};

/// Voxels are the block's, or larger where the object's box would have more than two million.
/// `offset_mm` moves the block along its x and y. Throws InputError as forward::make_polygrid()
/// does, whose boundary the values are interpolated from; `drawn` as in forward::PolygridOptions.
Wrapped wrapped(const io::VolumeSet& block, const TriangleMesh& mesh,
                const Eigen::Vector3d& offset_mm, const Polycube* drawn = nullptr);

}  // namespace kappamu::render
