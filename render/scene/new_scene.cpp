#include "render/scene/new_scene.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/mesh_file.h"
#include "io/volume/volume_file.h"
#include "render/material/published_materials.h"
#include "render/scene/measured_reflectance.h"

namespace kappamu::render {

namespace {

using nlohmann::ordered_json;

/// How a scene in `folder` names a file.
std::string named_from(const std::filesystem::path& folder, const std::string& file) {
  const std::filesystem::path from = std::filesystem::absolute(folder / ".").lexically_normal();
  return std::filesystem::absolute(file).lexically_normal().lexically_relative(from).string();
}

ordered_json block_object(const std::string& material, const std::filesystem::path& folder) {
  const GridShape shape = io::read_volume(io::find_shown_volume(material)).shape();
  const double h = shape.voxel_mm;
  ordered_json surface{
      {"_comment", "\"eta\" is the volume's where it states one; roughness is GGX's alpha"},
      {"roughness", 0.15}};
  if (measured_reflectance_file(material)) {
    surface["reflectance"] = {{"colour", 1}, {"measured", true}};
  }
  return {
      {"_comment",
       "the measured block, standing on its edge. For another shape write \"mesh\": a file (OBJ, "
       "PLY, STL, glTF) or \"shape\": a name, and \"size_mm\": the longest edge of its box"},
      {"name", "block"},
      {"shape", "cube"},
      {"size_mm", {h * shape.nx, h * shape.ny, h * shape.nz}},
      {"turn_deg", {180, 0, 0}},
      {"material",
       {{"_comment",
         "\"placement\": \"stretch\" fits the volume to the object's box; \"repeat\" and "
         "\"mirror\" tile it at its true scale, with \"turn_deg\" and \"offset_mm\""},
        {"volume", named_from(folder, material)},
        {"placement", "stretch"}}},
      {"surface", surface}};
}

/// Without a mesh a sphere.
ordered_json homogeneous_object(const std::string& material, const std::string& mesh = {}) {
  ordered_json object{
      {"_comment", "for another shape write \"mesh\": a file (OBJ, PLY, STL, glTF)"}};
  if (mesh.empty()) {
    object["name"] = object["shape"] = "sphere";
  } else {
    object["_comment"] = "size_mm: the longest edge of its box, whatever the file's unit is";
    object["name"] = std::filesystem::path(mesh).stem().string();
    object["mesh"] = mesh;
  }
  object["size_mm"] = 20;
  object["material"] = {{"_comment",
                         "or \"volume\": a run folder; or \"reduced_scattering_per_mm\" and "
                         "\"absorption_per_mm\" of R, G, B"},
                        {"published", material}};
  object["surface"] = {{"_comment", "roughness is GGX's alpha"}, {"roughness", 0.15}};
  return object;
}

/// The object that `what` is or is to be made of.
ordered_json object_of(const std::string& what, const std::filesystem::path& folder) {
  const std::vector<std::string> published = published_material_names();
  if (std::find(published.begin(), published.end(), what) != published.end()) {
    return homogeneous_object(what);
  }
  if (!std::filesystem::exists(what)) published_material(what);  // says which names there are
  if (io::is_mesh_file(what)) return homogeneous_object("marble", named_from(folder, what));
  return block_object(what, folder);
}

}  // namespace

std::string new_scene(const std::string& what, const std::filesystem::path& folder) {
  const ordered_json object = object_of(what, folder);
  double size = 0.0;
  if (object["size_mm"].is_array()) {
    for (const double edge : object["size_mm"]) size = std::max(size, edge);
  } else {
    size = object["size_mm"];
  }
  const ordered_json scene{
      {"format", "kappamu-scene"},
      {"version", 1},
      {"_comment",
       "Lengths in mm, y up. Light is relative to one unit of irradiance; colours are one number "
       "or "
       "[R, G, B]. Every object may have a _comment. Reference: docs/scene.md"},
      {"objects", {object}},
      {"lights",
       {{{"_comment", "a lamp behind the object, to its left: what passes through"},
         {"kind", "point"},
         {"position_mm", {-2.0 * size, 1.5 * size, -2.5 * size}},
         {"irradiance", {2.0, 1.9, 1.7}},
         {"at_mm", 3.5 * size}},
        {{"_comment", "a lamp in front, to its right"},
         {"kind", "spot"},
         {"position_mm", {2.0 * size, 2.0 * size, 3.0 * size}},
         {"target_mm", {0, 0, 0}},
         {"irradiance", 0.6},
         {"at_mm", 4.1 * size},
         {"cone_deg", 40}},
        {{"_comment", "even light from all sides; \"image\" takes a latitude-longitude EXR"},
         {"kind", "environment"},
         {"radiance", 0.03},
         {"visible", true}}}},
      {"camera",
       {{"position_mm", {0.8 * size, 0.7 * size, 3.0 * size}},
        {"target_mm", {0, 0, 0}},
        {"fov_deg", 25}}},
      {"film",
       {{"_comment",
         "\"exposure\" is a factor before the tone curve; left out, the picture sets it"},
        {"width", 640},
        {"height", 480},
        {"samples", 64}}},
      {"model",
       {{"_comment",
         "embedded: diffusion, refined to the tolerance; montecarlo: random walks, slower, where "
         "diffusion fails"},
        {"name", "embedded"},
        {"tolerance", 0.02}}}};
  return scene.dump(2) + "\n";
}

}  // namespace kappamu::render
