// A measured block wrapped round an object ([W] 5.2): its layers lie below the surface as they lay
// below the block's face z+, the block mirrored again and again along the faces of the object's
// polycube (a shell map, Porumbescu et al. 2005). Below the block's last layer its values there are
// interpolated inwards by mean-value coordinates (Ju et al. 2005), positive ones alone, so that no
// coefficient leaves the block's range.
#pragma once

#include "core/mesh/triangle_mesh.h"
#include "io/volume/volume_set.h"

namespace kappamu::render {

struct Wrapped {
  io::VolumeSet set;          ///< over the object's box
  Eigen::Vector3d corner_mm;  ///< of the set's own frame, in the object's
};

/// Voxels are the block's, or larger where the object's box would have more than two million.
/// `offset_mm` moves the block along its x and y. Where two faces of the polycube meet, the block's
/// pattern does not go on. Throws InputError as forward::make_polygrid() does.
Wrapped wrapped(const io::VolumeSet& block, const TriangleMesh& mesh,
                const Eigen::Vector3d& offset_mm);

}  // namespace kappamu::render
