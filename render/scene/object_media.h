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
  std::optional<double> eta;  ///< relative refractive index, where object or material states it
  std::optional<double> roughness;  ///< of the surface, where an edit states it
  std::string source;               ///< a file, or a citation
};

/// Where a volume lies in an object.
struct Placing {
  /// From the volume's own frame to the object's [mm to mm]: a turn after a stretch along the
  /// volume's axes.
  Eigen::Affine3d object_from_volume = Eigen::Affine3d::Identity();
  Wrap wrap = Wrap::clamp;
  std::string source;  ///< of the volume, or of the material that it is made of
};

/// Of a solid volume of this shape in an object of this box [mm].
Placing placing_of(const VolumeMaterial& material, const GridShape& shape,
                   const Eigen::Vector3d& box, const std::string& source);

/// An object's material as a volume.
struct PlacedVolume {
  io::VolumeSet set;
  Placing placing;
};

/// A volume lies in the box of `rest`, the object before its deformations [mm], which is centred at
/// the origin; a shell and a composed material lie in `mesh`, the object as it is. A homogeneous
/// material becomes a volume over the box of `rest`, of voxels of `voxel_mm`: by itself the smaller
/// of a mean free path 3κ and a 64th of the longest edge, and larger where there would be more than
/// two million. Throws InputError naming the object and what is wrong: no channels R, G, B (a
/// single channel serves all three), an object smaller than a voxel, what a field's maker refuses.
PlacedVolume placed_volume(const SceneObject& object, const TriangleMesh& rest,
                           const TriangleMesh& mesh, std::optional<double> voxel_mm,
                           std::vector<std::string>& warnings);

/// The media of an object without edits.
ObjectMedia make_object_media(const SceneObject& object, const TriangleMesh& rest,
                              const TriangleMesh& mesh, std::vector<std::string>& warnings);

/// Of a homogeneous object: R, G, B of one voxel.
io::VolumeSet one_voxel(const HomogeneousMaterial& material);

/// Throws InputError naming the source unless the volume has channels R, G, B, or one for all.
ObjectMedia media_of(const io::VolumeSet& set, const Placing& placing);
/// The same, with the set's own voxels.
ObjectMedia media_of(io::VolumeSet&& set, const Placing& placing);
/// Of one voxel: the same everywhere.
ObjectMedia media_of(const io::VolumeSet& voxel, const std::string& source);

/// R, G, B of a volume in this order, or its single channel; `file` names it. Throws InputError
/// where there are other channels only.
io::VolumeSet colour_channels(const io::VolumeSet& set, const std::string& file);

}  // namespace kappamu::render
