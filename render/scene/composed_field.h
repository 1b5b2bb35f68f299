// The field of a scene's material.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/mesh/triangle_mesh.h"
#include "core/progress.h"
#include "render/material/material_field.h"
#include "render/scene/scene.h"

namespace kappamu::render {

struct NamedField {
  std::unique_ptr<MaterialField> field;
  std::optional<double> eta;  ///< relative refractive index of the outermost material
  std::string source;
};

/// `mesh`, in whose frame the field is, outlives it. Reads the volumes that the material names.
/// Throws InputError.
NamedField make_field(const Material& material, const TriangleMesh& mesh);

/// Gives `progress` the memory that wrapping each object's block needs at most, before it begins.
/// Throws InputError where that does not fit, and as read_volume().
void expect_wrap_memory(const Scene& scene, Progress& progress);

}  // namespace kappamu::render
