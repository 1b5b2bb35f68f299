// The reflectance of a sample's surface that a fit measured beside its volume ([W] 6.1), laid on an
// object as the volume is.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "core/mesh/triangle_mesh.h"
#include "render/scene/scene.h"
#include "render/surface/surface_maps.h"

namespace kappamu::render {

/// The picture that a fit left beside the volume, reflectance_z-.exr or reflectance_z+.exr.
std::optional<std::filesystem::path> measured_reflectance_file(const std::filesystem::path& volume);

/// Of a solid volume, on the parts of the surface that face as the measured face does: in full up
/// to 53 degrees, none from 78 degrees on. Of a shell, all over the surface, in the same pieces as
/// the volume. `rest` and `mesh` as of placed_volume(). Throws InputError: another material than a
/// volume, no picture, one of another size, or of the face that a shell has inside.
std::shared_ptr<const PlacedReflectance> measured_reflectance(const Material& material,
                                                              const TriangleMesh& rest,
                                                              const TriangleMesh& mesh);

}  // namespace kappamu::render
