#include "render/material/published_materials.h"

#include <array>

#include "core/error.h"

namespace kappamu::render {

namespace {

struct Row {
  const char* name;
  std::array<double, 3> scattering;  ///< σs' [1/mm]
  std::array<double, 3> absorption;  ///< σa [1/mm]
  double eta;
  const char* source;
};

constexpr const char* jensen2001 =
    "H. W. Jensen, S. R. Marschner, M. Levoy, P. Hanrahan, A practical model for subsurface light "
    "transport, SIGGRAPH 2001, figure 5";
/// By similarity, σs' = (1 − g)σs. The index is that of water-based media, assumed.
constexpr const char* narasimhan2006 =
    "S. G. Narasimhan et al., Acquiring scattering properties of participating media by dilution, "
    "SIGGRAPH 2006, as reduced scattering in the table of pbrt-v4 (src/pbrt/media.cpp)";

constexpr Row rows[] = {
#include "render/material/published_materials.inc"
};

Colour colour(const std::array<double, 3>& rgb) {
  return {rgb[0], rgb[1], rgb[2]};
}

}  // namespace

std::vector<std::string> published_material_names() {
  std::vector<std::string> names;
  for (const Row& row : rows) names.emplace_back(row.name);
  return names;
}

HomogeneousMaterial published_material(const std::string& name) {
  std::string names;
  for (const Row& row : rows) {
    if (name == row.name) {
      HomogeneousMaterial material =
          homogeneous_material(colour(row.scattering), colour(row.absorption));
      material.eta = row.eta;
      material.source = row.source;
      return material;
    }
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw InputError("'" + name + "' is no published material; write one of " + names);
}

}  // namespace kappamu::render
