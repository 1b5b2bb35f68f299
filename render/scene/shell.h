// A measured block wrapped round an object ([W] 5.2): its layers lie below the surface as they lay
// below the block's face z+ (a shell map, Porumbescu et al. 2005), the block mirrored again and
// again along the planes of the object's axes, blended by the normal, so that the pattern goes on
// all round. Below the block's last layer its values there are interpolated inwards by mean-value
// coordinates (Ju et al. 2005), positive ones alone, so that no coefficient leaves the block's
// range.
#pragma once

#include <optional>

#include "core/mesh/polycube.h"
#include "core/mesh/triangle_mesh.h"
#include "io/volume/volume_set.h"

namespace kappamu::render {

/// Over the object's box, into which the volume is stretched: its voxels are the block's, or larger
/// where there would be more than two million; or of `voxel_mm`. `offset_mm` moves the block along
/// its x and y. Throws InputError as forward::make_polygrid() does, whose boundary the values are
/// interpolated from; `drawn` as in forward::PolygridOptions.
io::VolumeSet wrapped(const io::VolumeSet& block, const TriangleMesh& mesh,
                      const Eigen::Vector3d& offset_mm, const Polycube* drawn = nullptr,
                      std::optional<double> voxel_mm = std::nullopt);

/// Voxels of edge `voxel_mm` that fill a box [mm]; the last of each axis may reach beyond it.
/// Throws InputError where they are more than a volume may have.
GridShape voxels_of(const Eigen::Vector3d& box, double voxel_mm);

/// The smallest edge of voxels of which a box [mm] holds two million at most.
double smallest_voxel(const Eigen::Vector3d& box);

}  // namespace kappamu::render
