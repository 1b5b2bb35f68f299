// κ and μ of a scene's object, one medium per colour channel.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "core/mesh/polycube.h"
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

/// Of a volume of this shape in an object of this box [mm]; a shell's is over the whole box.
Placing placing_of(const VolumeMaterial& material, const GridShape& shape,
                   const Eigen::Vector3d& box, const std::string& source);

/// An object's material as a volume.
struct PlacedVolume {
  io::VolumeSet set;
  Placing placing;
};

/// `mesh` is the object [mm], its box centred at the origin. A homogeneous or wrapped one becomes a
/// volume over the object's box, of voxels of `voxel_mm`. By itself they are those of the wrapped
/// block; of a homogeneous one the smaller of a mean free path 3κ and a 64th of the longest edge;
/// and larger where there would be more than two million. Throws InputError naming the object and
/// what is wrong. `drawn` as in forward::PolygridOptions.
PlacedVolume placed_volume(const SceneObject& object, const TriangleMesh& mesh,
                           const Polycube* drawn = nullptr,
                           std::optional<double> voxel_mm = std::nullopt);

/// Of a homogeneous object: R, G, B of one voxel.
io::VolumeSet one_voxel(const HomogeneousMaterial& material);

/// Throws InputError naming the source unless the volume has channels R, G, B, or one for all.
ObjectMedia media_of(const io::VolumeSet& set, const Placing& placing);
/// Of one voxel: the same everywhere.
ObjectMedia media_of(const io::VolumeSet& voxel, const std::string& source);

}  // namespace kappamu::render
