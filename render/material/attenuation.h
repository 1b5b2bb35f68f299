// Absorption as renderers of clear media state it: the colour that white light has after a
// distance.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "render/colour.h"

namespace kappamu::render {

/// White light has `colour` after `distance_mm`: colour = e^(−μ distance).
struct Attenuation {
  Colour colour = Colour::Ones();  ///< in (0, 1]
  double distance_mm = 1.0;        ///< may be infinite: no absorption
};

/// μ = −ln(colour)/distance [1/mm].
Colour absorption_of(const Attenuation& attenuation);

struct FileMaterialChoice {
  std::filesystem::path file;         ///< .gltf, .glb or .mtl
  std::optional<std::string> name;    ///< of the material; none: the file's only one
  double mm_per_unit = 1000.0;        ///< of glTF lengths, which are metres
  std::optional<double> distance_mm;  ///< after which light has the colour Tf of MTL
};

struct FileMaterial {
  Attenuation attenuation;
  std::optional<double> eta;  ///< refractive index, where stated
  std::string source;
};

/// glTF: KHR_materials_volume (attenuationColor, attenuationDistance) and KHR_materials_ior (1.5
/// where it is absent), of a material that transmits (KHR_materials_transmission or
/// KHR_materials_diffuse_transmission). MTL: Tf, whose distance the format does not state, and Ni.
/// Throws InputError naming file, material and what is missing.
FileMaterial read_file_material(const FileMaterialChoice& choice);

}  // namespace kappamu::render
