// A volume as one homogeneous material of surface shaders (render/material/subsurface.h).
#pragma once

#include <filesystem>

#include "io/volume/volume_export.h"
#include "io/volume/volume_set.h"

namespace kappamu::render {

/// Into `folder`: material.mtlx, MaterialX 1.39 with an open_pbr_surface in millimetres, and
/// principled.json, colour and radius [mm] of Blender's Principled BSDF. σs' + μ and μ are the
/// volume's means; a warning states by how much they vary, where they do. Throws InputError as
/// io::validate does.
io::ExportResult export_material(const std::filesystem::path& folder, const io::VolumeSet& set);

}  // namespace kappamu::render
