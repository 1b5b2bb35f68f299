// κ and μ of a scene's object, one medium per colour channel.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/object_medium.h"
#include "io/volume/volume_set.h"
#include "render/scene/scene.h"

namespace kappamu::render {

struct ObjectMedia {
  /// R, G, B; channels of equal coefficients share one.
  std::array<std::shared_ptr<const ObjectMedium>, 3> channels;
  std::optional<double> eta;  ///< relative refractive index, where the material states it
  std::string source;         ///< a file, or a citation
};

/// A volume lies in the box of `rest`, the object before its deformations [mm], which is centred at
/// the origin; a shell lies below the surface of `mesh`, the object as it is.
/// Throws InputError naming the object and what is wrong: no channels R, G, B (a single channel
/// serves all three), an object smaller than a voxel, what a field's maker refuses.
ObjectMedia make_object_media(const SceneObject& object, const TriangleMesh& rest,
                              const TriangleMesh& mesh, std::vector<std::string>& warnings);

/// R, G, B of a volume in this order, or its single channel; `file` names it. Throws InputError
/// where there are other channels only.
io::VolumeSet colour_channels(const io::VolumeSet& set, const std::string& file);

/// Of a volume in memory, placed as the object's material says, not as a shell; `box` is the
/// object's size [mm]. `source` names it.
ObjectMedia media_of(const io::VolumeSet& set, const SceneObject& object,
                     const Eigen::Vector3d& box, const std::string& source);

/// Of a solid placement.
Wrap wrap_of(VolumeMaterial::Placement placement);

/// From the volume's own frame to the object's [mm to mm]: a turn after a stretch along the
/// volume's axes.
Eigen::Affine3d object_from_volume(const VolumeMaterial& material, const GridShape& shape,
                                   const Eigen::Vector3d& box);

}  // namespace kappamu::render
