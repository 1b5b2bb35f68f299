#include "render/scene/material_read.h"

#include <array>

#include "core/error.h"
#include "render/edit/edit.h"
#include "render/material/attenuation.h"
#include "render/material/published_materials.h"
#include "render/material/subsurface.h"
#include "render/node_values.h"

namespace kappamu::render {

namespace {

using Node = io::JsonNode;
using Eigen::Vector3d;

constexpr double most_per_mm = 1e4, least_scattering = 1e-6;
constexpr int most_nested = 16;

Colour scattering_of(const Node& node) {
  return colour_of(node["reduced_scattering_per_mm"], most_per_mm, least_scattering);
}

Material material_of(const Node& node, const std::filesystem::path& folder, int depth);

HomogeneousMaterial published_of(const Node& node) {
  node.expect_fields({"published"}, {"density"});
  try {
    return published_material(node["published"].text());
  } catch (const InputError& error) {
    node["published"].fail(std::string("is wrong: ") + error.what());
  }
}

HomogeneousMaterial subsurface_of(const Node& node) {
  node.expect_fields({"subsurface"}, {"density"});
  const Node inner = node["subsurface"];
  inner.expect_fields({"colour", "radius_mm"}, {"convention", "anisotropy"});
  Subsurface subsurface;
  subsurface.colour = colour_of(inner["colour"], 0.9999);
  subsurface.radius_mm = colour_of(inner["radius_mm"], 1e3, 1e-4);
  if (inner.has("convention")) subsurface.convention = inner["convention"].named(convention_names);
  if (inner.has("anisotropy")) {
    if (subsurface.convention == Subsurface::Convention::principled)
      inner["anisotropy"].fail("belongs to the convention openpbr; remove it");
    subsurface.anisotropy = inner["anisotropy"].number_between(-0.95, 0.95);
  }
  return material_of(subsurface);
}

/// Absorption by colour and distance, scattering stated beside it.
HomogeneousMaterial attenuation_of(const Node& node) {
  node.expect_fields({"attenuation", "reduced_scattering_per_mm"}, {"density"});
  const Node inner = node["attenuation"];
  inner.expect_fields({"colour", "distance_mm"});
  HomogeneousMaterial material = homogeneous_material(
      scattering_of(node), absorption_of({colour_of(inner["colour"], 1.0, 1e-6),
                                          inner["distance_mm"].number_between(1e-6, 1e6)}));
  material.source = "attenuation colour and distance of the scene";
  return material;
}

/// The transmission of a material in a glTF or MTL file.
HomogeneousMaterial file_of(const Node& node, const std::filesystem::path& folder) {
  node.expect_fields({"file", "reduced_scattering_per_mm"},
                     {"name", "mm_per_unit", "distance_mm", "density"});
  FileMaterialChoice choice;
  choice.file = path_of(node["file"], folder);
  if (node.has("name")) choice.name = name_of(node["name"]);
  if (node.has("mm_per_unit")) choice.mm_per_unit = node["mm_per_unit"].number_between(1e-6, 1e6);
  if (node.has("distance_mm")) choice.distance_mm = node["distance_mm"].number_between(1e-6, 1e6);
  const FileMaterial read = read_file_material(choice);
  HomogeneousMaterial material =
      homogeneous_material(scattering_of(node), absorption_of(read.attenuation));
  material.eta = read.eta;
  material.source = read.source;
  material.file = choice.file;
  return material;
}

HomogeneousMaterial own_of(const Node& node) {
  node.expect_fields({"reduced_scattering_per_mm", "absorption_per_mm"}, {"source", "density"});
  HomogeneousMaterial material =
      homogeneous_material(scattering_of(node), colour_of(node["absorption_per_mm"], most_per_mm));
  material.source = node.has("source") ? node["source"].text() : "the scene";
  return material;
}

HomogeneousMaterial diffusion_of(const Node& node) {
  node.expect_fields({"kappa_mm", "mu_per_mm"}, {"source", "density"});
  HomogeneousMaterial material;
  material.kappa_mm = colour_of(node["kappa_mm"], largest_kappa_mm, smallest_kappa_mm);
  material.mu_per_mm = colour_of(node["mu_per_mm"], largest_mu_per_mm);
  material.source = node.has("source") ? node["source"].text() : "the scene";
  return material;
}

/// `density` multiplies σs' and μ.
HomogeneousMaterial denser(HomogeneousMaterial material, const Node& node) {
  if (!node.has("density")) return material;
  const double density = node["density"].number_between(1e-4, 1e4);
  material.kappa_mm /= density;
  material.mu_per_mm *= density;
  return material;
}

Shell shell_of(const Node& node) {
  Shell shell;
  if (node.has("up")) shell.up = direction_of(node["up"]);
  if (node.has("scale")) shell.scale = node["scale"].number_between(0.01, 100.0);
  if (node.has("texture_size_mm")) {
    const std::vector<Node> uv = node["texture_size_mm"].exactly(2);
    shell.texture_size_mm = Eigen::Vector2d(length_of(uv[0]), length_of(uv[1]));
  }
  if (node.has("face")) {
    shell.outside = node["face"].choice({"z-", "z+"}) == "z-" ? Shell::Outside::z_minus
                                                              : Shell::Outside::z_plus;
  }
  if (node.has("core")) {
    const std::string core = node["core"].choice({"synthesised", "mean-values"});
    shell.core = core == "synthesised" ? Shell::Core::synthesised : Shell::Core::mean_values;
  }
  if (node.has("seed"))
    shell.seed = static_cast<std::uint64_t>(whole_number(node["seed"], 0, 1 << 30));
  return shell;
}

VolumeMaterial volume_of(const Node& node, const std::filesystem::path& folder) {
  node.expect_fields({"volume"}, {"placement", "turn_deg", "offset_mm", "up", "scale",
                                  "texture_size_mm", "core", "seed", "face"});
  VolumeMaterial material;
  material.volume = path_of(node["volume"], folder);
  if (node.has("placement")) {
    using Placement = VolumeMaterial::Placement;
    const std::string name = node["placement"].choice({"stretch", "repeat", "mirror", "shell"});
    material.placement = name == "repeat"   ? Placement::repeat
                         : name == "mirror" ? Placement::mirror
                         : name == "shell"  ? Placement::shell
                                            : Placement::stretch;
  }
  const bool is_shell = material.placement == VolumeMaterial::Placement::shell;
  for (const char* field : {"turn_deg", "offset_mm"}) {
    if (is_shell && node.has(field))
      node[field].fail("has no meaning for a shell, which follows the surface; write 'up'");
  }
  for (const char* field : {"up", "scale", "texture_size_mm", "core", "seed", "face"}) {
    if (!is_shell && node.has(field))
      node[field].fail("belongs to \"placement\": \"shell\"; remove it");
  }
  if (is_shell) material.shell = shell_of(node);
  if (node.has("turn_deg")) material.turn_deg = three_of(node["turn_deg"], -360.0, 360.0);
  if (node.has("offset_mm")) material.offset_mm = point_of(node["offset_mm"]);
  return material;
}

Pattern pattern_of(const Node& node) {
  constexpr Names<Pattern::Kind, 3> names{{{"noise", Pattern::Kind::noise},
                                           {"marble", Pattern::Kind::marble},
                                           {"veins", Pattern::Kind::veins}}};
  node.expect_fields({"kind", "size_mm"}, {"octaves", "turbulence", "width", "direction", "seed"});
  Pattern pattern;
  pattern.kind = node["kind"].named(names);
  pattern.size_mm = length_of(node["size_mm"]);
  if (node.has("octaves")) pattern.octaves = whole_number(node["octaves"], 1, 10);
  const auto only = [&](const char* field, Pattern::Kind kind, const std::string& name) {
    if (node.has(field) && pattern.kind != kind)
      node[field].fail("belongs to the kind " + name + "; remove it");
    return node.has(field);
  };
  if (only("turbulence", Pattern::Kind::marble, "marble"))
    pattern.turbulence = node["turbulence"].number_between(0.0, 100.0);
  if (only("direction", Pattern::Kind::marble, "marble"))
    pattern.direction = direction_of(node["direction"]);
  if (only("width", Pattern::Kind::veins, "veins"))
    pattern.width = node["width"].number_between(0.001, 10.0);
  if (node.has("seed"))
    pattern.seed = static_cast<std::uint64_t>(whole_number(node["seed"], 0, 1 << 30));
  return pattern;
}

Material mix_of(const Node& node, const std::filesystem::path& folder, int depth) {
  node.expect_fields({"mix", "pattern"});
  auto mix = std::make_shared<ComposedMaterial>();
  for (const Node& one : node["mix"].exactly(2))
    mix->materials.push_back(material_of(one, folder, depth + 1));
  mix->by = pattern_of(node["pattern"]);
  return mix;
}

Material layers_of(const Node& node, const std::filesystem::path& folder, int depth) {
  node.expect_fields({"layers"});
  auto made = std::make_shared<ComposedMaterial>();
  ComposedMaterial::Layers layers;
  const std::vector<Node> items = node["layers"].items(2);
  for (const Node& item : items) {
    const bool last = made->materials.size() + 1 == items.size();
    if (last) {
      item.expect_fields({"material"});
    } else {
      item.expect_fields({"material", "thickness_mm"});
      layers.thickness_mm.push_back(length_of(item["thickness_mm"]));
    }
    made->materials.push_back(material_of(item["material"], folder, depth + 1));
  }
  made->by = layers;
  return made;
}

Material parts_of(const Node& node, const std::filesystem::path& folder, int depth) {
  node.expect_fields({"parts", "around"});
  auto made = std::make_shared<ComposedMaterial>();
  made->materials.push_back(material_of(node["around"], folder, depth + 1));
  ComposedMaterial::Parts parts;
  for (const Node& item : node["parts"].items(1)) {
    item.expect_fields({"size_mm", "material"},
                       {"name", "mesh", "shape", "proportion", "position_mm", "turn_deg"});
    parts.parts.push_back(read_solid(item, folder));
    parts.parts.back().name = "part " + std::to_string(parts.parts.size());
  }
  made->by = std::move(parts);
  return made;
}

Material material_of(const Node& node, const std::filesystem::path& folder, int depth) {
  if (depth > most_nested) node.fail("is nested too deeply; write it flatter");
  // "attenuation" and "file" state their scattering beside them.
  constexpr std::array<const char*, 8> kinds{"volume", "published", "subsurface", "attenuation",
                                             "file",   "mix",       "layers",     "parts"};
  std::string kind;
  int found = 0;
  for (const char* one : kinds) {
    if (!node.has(one)) continue;
    kind = one;
    ++found;
  }
  if (found == 0 && node.has("reduced_scattering_per_mm")) return denser(own_of(node), node);
  if (found == 0 && node.has("kappa_mm")) return denser(diffusion_of(node), node);
  if (found != 1) {
    node.fail(
        "must have exactly one of 'volume', 'published', 'reduced_scattering_per_mm', 'kappa_mm', "
        "'subsurface', 'attenuation', 'file', 'mix', 'layers' and 'parts'");
  }
  if (kind == "volume") return volume_of(node, folder);
  if (kind == "mix") return mix_of(node, folder, depth);
  if (kind == "layers") return layers_of(node, folder, depth);
  if (kind == "parts") return parts_of(node, folder, depth);
  if (kind == "published") return denser(published_of(node), node);
  if (kind == "subsurface") return denser(subsurface_of(node), node);
  if (kind == "attenuation") return denser(attenuation_of(node), node);
  return denser(file_of(node, folder), node);
}

}  // namespace

Material read_material(const Node& node, const std::filesystem::path& folder) {
  return material_of(node, folder, 0);
}

SceneObject read_solid(const Node& node, const std::filesystem::path& folder) {
  if (node.has("mesh") == node.has("shape")) {
    node.fail("must have either 'mesh' (a file) or 'shape' (a name)");
  }
  SceneObject object;
  if (node.has("name")) object.name = name_of(node["name"]);
  if (node.has("mesh")) {
    if (node.has("proportion")) node["proportion"].fail("belongs to named shapes; remove it");
    object.shape = path_of(node["mesh"], folder);
    if (node.has("morph")) {
      for (const Node& weight : node["morph"].items(1)) {
        object.morph.push_back(weight.number_between(-100.0, 100.0));
      }
    }
    if (node.has("fitted_as")) object.fitted_as = path_of(node["fitted_as"], folder);
  } else {
    for (const char* field : {"fitted_as", "morph"}) {
      if (node.has(field)) node[field].fail("belongs to a mesh; remove it");
    }
    object.shape = name_of(node["shape"]);
    if (node.has("proportion")) object.proportion = node["proportion"].number_between(0.0, 1.0);
  }
  object.size_mm = size_of(node["size_mm"]);
  if (node.has("position_mm")) object.position_mm = point_of(node["position_mm"]);
  if (node.has("turn_deg")) object.turn_deg = three_of(node["turn_deg"], -360.0, 360.0);
  object.material = read_material(node["material"], folder);
  return object;
}

}  // namespace kappamu::render
