// A scene's file to Scene: fields, types, bounds. What needs the files it names is checked where
// they are read (world.cpp).
#include <Eigen/Geometry>
#include <cmath>
#include <set>
#include <variant>

#include "core/error.h"
#include "core/file_name.h"
#include "forward/registry.h"
#include "io/json_node.h"
#include "io/mesh_file.h"
#include "render/deform/deform_file.h"
#include "render/edit/edit.h"
#include "render/hair/fur_file.h"
#include "render/node_values.h"
#include "render/scene/material_read.h"
#include "render/scene/scene.h"

namespace kappamu::render {

namespace {

using Node = io::JsonNode;
using Eigen::Vector3d;

constexpr const char* page = "docs/scene.md";

SurfaceImage read_surface_image(const Node& node, const std::filesystem::path& folder) {
  SurfaceImage image{path_of(node["image"], folder), std::nullopt};
  if (node.has("size_mm")) {
    const std::vector<Node> uv = node["size_mm"].exactly(2);
    image.size_mm = Eigen::Vector2d(length_of(uv[0]), length_of(uv[1]));
  }
  return image;
}

SurfaceDetail read_detail(const Node& node, const std::filesystem::path& folder) {
  SurfaceDetail detail;
  if (node.has("bump")) {
    node["bump"].expect_fields({"image", "depth_mm"}, {"size_mm"});
    detail.bump = read_surface_image(node["bump"], folder);
    detail.depth_mm = node["bump"]["depth_mm"].number_between(-largest_mm, largest_mm);
  }
  if (node.has("gloss")) {
    const Node gloss = node["gloss"];
    gloss.expect_fields({"image", "roughness"}, {"size_mm"});
    detail.gloss = read_surface_image(gloss, folder);
    const std::vector<Node> ends = gloss["roughness"].exactly(2);
    detail.dull = ends[0].number_between(0.0, 1.0);
    detail.glossy = ends[1].number_between(0.0, 1.0);
  }
  if (node.has("reflectance")) {
    const Node reflectance = node["reflectance"];
    reflectance.expect_fields({"colour"}, {"image", "size_mm", "measured"});
    detail.reflectance = colour_of(reflectance["colour"], 1.0);
    if (reflectance.has("measured")) detail.reflectance_measured = reflectance["measured"].flag();
    if (detail.reflectance_measured && reflectance.has("image")) {
      reflectance["image"].fail("cannot stand beside \"measured\": true; remove one of the two");
    }
    if (reflectance.has("image")) {
      detail.reflectance_image = read_surface_image(reflectance, folder);
    } else if (reflectance.has("size_mm")) {
      reflectance["size_mm"].fail("is an image's; add 'image' or remove it");
    }
  }
  return detail;
}

Finish read_finish(const Node& node, const std::filesystem::path& folder) {
  node.expect_fields({}, {"eta", "roughness", "bump", "gloss", "reflectance"});
  Finish finish;
  if (node.has("eta")) finish.eta = node["eta"].number_between(1.0, 4.0);
  if (node.has("roughness")) finish.roughness = node["roughness"].number_between(0.0, 1.0);
  finish.detail = read_detail(node, folder);
  return finish;
}

double longest_edge(const std::variant<double, Vector3d>& size_mm) {
  const auto* edges = std::get_if<Vector3d>(&size_mm);
  return edges != nullptr ? edges->maxCoeff() : std::get<double>(size_mm);
}

/// A recipe's file, and what it makes of the scene's lights.
struct RecipeLights {
  std::string file;
  LightChanges changes;
};

/// Adds the lights of the object's recipe to `lights`.
SceneObject read_object(const Node& node, const std::filesystem::path& folder,
                        std::vector<RecipeLights>& lights) {
  node.expect_fields(
      {"name", "size_mm", "material"},
      {"mesh", "fitted_as", "morph", "shape", "proportion", "position_mm", "turn_deg", "surface",
       "polycube", "fur", "deform", "edits", "emission_per_mm"});
  SceneObject object = read_solid(node, folder);
  if (node.has("edits")) object.edits = path_of(node["edits"], folder);
  if (node.has("surface")) {
    object.finish = read_finish(node["surface"], folder);
    const SurfaceDetail& detail = object.finish.detail;
    if (detail.bump && std::abs(detail.depth_mm) > 0.25 * longest_edge(object.size_mm)) {
      node["surface"]["bump"]["depth_mm"].fail(
          "is more than a quarter of the object's size; a bump tilts normals alone, give what is "
          "deeper as 'deform' or by the mesh");
    }
  }
  if (node.has("emission_per_mm")) {
    object.emission = colour_of(node["emission_per_mm"], largest_light);
  }
  if (node.has("polycube")) object.polycube = path_of(node["polycube"], folder);
  if (node.has("fur")) object.fur = read_fur(node["fur"], folder);
  if (node.has("deform")) object.deform = read_deformations(node["deform"]);
  object.deform_unedited = object.deform;
  if (object.edits) {
    Recipe recipe = read_recipe(*object.edits);
    for (const Edit& edit : recipe.edits) {
      edit.deform_on(object.deform);
      if (object.fur) edit.change(*object.fur);
    }
    lights.push_back({object.edits->string(), std::move(recipe.lights)});
  }
  return object;
}

PointLight read_point(const Node& node) {
  PointLight light;
  light.position_mm = point_of(node["position_mm"]);
  light.irradiance = colour_of(node["irradiance"], largest_light);
  light.at_mm = length_of(node["at_mm"]);
  return light;
}

Vector3d target_of(const Node& node, const Vector3d& position) {
  const Vector3d target = point_of(node);
  if ((target - position).norm() < smallest_mm) {
    node.fail("lies at position_mm; move one of the two");
  }
  return target;
}

/// The field "up" of a camera or projector that looks along `forward`; +y unless stated.
Vector3d read_up(const Node& node, const Vector3d& forward) {
  const Vector3d up = node.has("up") ? direction_of(node["up"]) : Vector3d::UnitY();
  if (up.cross(forward.normalized()).norm() < 1e-6) {
    node.fail("looks along its 'up'; write an 'up' across the line to target_mm");
  }
  return up;
}

Light read_light(const Node& node, const std::filesystem::path& folder) {
  if (!node.has("kind")) node.fail("has no field 'kind'; add it (docs/scene.md)");
  const std::string kind =
      node["kind"].choice({"directional", "point", "spot", "projector", "environment"});
  if (kind == "directional") {
    node.expect_fields({"kind", "direction", "irradiance"});
    return DirectionalLight{direction_of(node["direction"]),
                            colour_of(node["irradiance"], largest_light)};
  }
  if (kind == "point") {
    node.expect_fields({"kind", "position_mm", "irradiance", "at_mm"});
    return read_point(node);
  }
  if (kind == "spot") {
    node.expect_fields({"kind", "position_mm", "target_mm", "irradiance", "at_mm", "cone_deg"},
                       {"edge_deg"});
    SpotLight light;
    light.point = read_point(node);
    light.target_mm = target_of(node["target_mm"], light.point.position_mm);
    light.cone_deg = node["cone_deg"].number_between(0.01, 180.0);
    light.edge_deg = node.has("edge_deg")
                         ? node["edge_deg"].number_between(0.0, 0.5 * light.cone_deg)
                         : 0.1 * light.cone_deg;
    return light;
  }
  if (kind == "projector") {
    node.expect_fields(
        {"kind", "position_mm", "target_mm", "irradiance", "at_mm", "fov_deg", "image"}, {"up"});
    ProjectorLight light;
    light.point = read_point(node);
    light.target_mm = target_of(node["target_mm"], light.point.position_mm);
    light.up = read_up(node, light.target_mm - light.point.position_mm);
    light.fov_deg = node["fov_deg"].number_between(0.01, 170.0);
    light.image = path_of(node["image"], folder);
    return light;
  }
  node.expect_fields({"kind", "radiance"}, {"image", "turn_deg", "visible"});
  EnvironmentLight light;
  light.radiance = colour_of(node["radiance"], largest_light);
  if (node.has("image")) light.image = path_of(node["image"], folder);
  if (node.has("turn_deg")) light.turn_deg = node["turn_deg"].number_between(-360.0, 360.0);
  if (node.has("visible")) light.visible = node["visible"].flag();
  return light;
}

Camera read_camera(const Node& node) {
  node.expect_fields({"position_mm", "target_mm", "fov_deg"}, {"up"});
  Camera camera;
  camera.position_mm = point_of(node["position_mm"]);
  camera.target_mm = target_of(node["target_mm"], camera.position_mm);
  camera.up = read_up(node, camera.target_mm - camera.position_mm);
  camera.fov_deg = node["fov_deg"].number_between(0.01, 170.0);
  return camera;
}

Film read_film(const Node& node) {
  node.expect_fields({"width", "height"}, {"samples", "exposure"});
  Film film;
  film.width = whole_number(node["width"], 1, 16384);
  film.height = whole_number(node["height"], 1, 16384);
  if (node.has("samples")) film.samples = whole_number(node["samples"], 1, 65536);
  if (node.has("exposure")) film.exposure = node["exposure"].number_between(1e-9, 1e9);
  return film;
}

OptionValue read_option(const Node& node, const Option& option, OptionReference reference) {
  OptionValue value = std::holds_alternative<bool*>(reference) ? OptionValue(node.flag())
                      : std::holds_alternative<std::string*>(reference)
                          ? OptionValue(node.text())
                          : OptionValue(node.number());
  try {
    set_option(option, reference, value);
  } catch (const InputError& error) {
    node.fail(std::string("is wrong: ") + error.what());
  }
  return value;
}

ModelChoice read_model(const Node& node) {
  if (!node.has("name"))
    node.expect_fields({"name"}, {"tolerance", "max_elements", "follow_reentry"});
  ModelChoice choice;
  std::vector<std::string> names;
  for (const forward::ModelDescription& model : forward::object_models())
    names.push_back(model.name);
  choice.name = node["name"].one_of(names);
  const auto model = forward::object_model(choice.name).make();
  std::vector<std::string_view> optional{"tolerance", "max_elements", "follow_reentry"};
  model->describe([&](const Option& option, OptionReference reference) {
    optional.push_back(option.name);
    if (node.has(option.name))
      choice.parameters[option.name] = read_option(node[option.name], option, reference);
  });
  node.expect_fields({"name"}, optional);
  if (node.has("tolerance")) choice.tolerance = node["tolerance"].number_between(1e-6, 1.0);
  if (node.has("max_elements")) {
    choice.max_elements =
        static_cast<std::uint64_t>(node["max_elements"].number_between(1.0, 1e10));
  }
  if (node.has("follow_reentry")) choice.follow_reentry = node["follow_reentry"].flag();
  return choice;
}

}  // namespace

namespace {

Scene scene_of(const io::JsonDocument& document, const std::filesystem::path& file) {
  const Node root = document.root();
  root.expect_fields({"format", "version", "objects", "lights", "camera", "film"}, {"model"});
  root.expect_format("kappamu-scene");
  Scene scene;
  scene.file = file;
  const std::filesystem::path folder = file.parent_path();
  std::set<std::string> names;
  std::vector<RecipeLights> recipes;
  for (const Node& node : root["objects"].items(1)) {
    scene.objects.push_back(read_object(node, folder, recipes));
    if (!names.insert(scene.objects.back().name).second) {
      node["name"].fail("is another object's name too; rename one of the two");
    }
  }
  int environments = 0;
  for (const Node& node : root["lights"].items(1)) {
    scene.lights.push_back(read_light(node, folder));
    if (std::holds_alternative<EnvironmentLight>(scene.lights.back()) && ++environments > 1) {
      node.fail("is a second environment; keep one");
    }
  }
  for (std::size_t i = 0; i < recipes.size(); ++i) {
    const RecipeLights& recipe = recipes[i];
    for (std::size_t before = 0; before < i; ++before) {
      expect_agreement(recipe.changes, recipe.file, recipes[before].changes, recipes[before].file);
    }
    change_lights(recipe.changes, recipe.file, scene.lights);
  }
  scene.camera = read_camera(root["camera"]);
  scene.film = read_film(root["film"]);
  if (root.has("model")) scene.model = read_model(root["model"]);
  return scene;
}

void add_files(const Material& material, std::vector<std::filesystem::path>& files) {
  if (const auto* volume = std::get_if<VolumeMaterial>(&material)) files.push_back(volume->volume);
  if (const auto* even = std::get_if<HomogeneousMaterial>(&material);
      even != nullptr && even->file) {
    files.push_back(*even->file);
  }
  const auto* composed = std::get_if<std::shared_ptr<const ComposedMaterial>>(&material);
  if (composed == nullptr) return;
  for (const Material& one : (*composed)->materials) add_files(one, files);
  const auto* parts = std::get_if<ComposedMaterial::Parts>(&(*composed)->by);
  if (parts == nullptr) return;
  for (const SceneObject& part : parts->parts) {
    if (const auto* mesh = std::get_if<std::filesystem::path>(&part.shape)) files.push_back(*mesh);
    add_files(part.material, files);
  }
}

}  // namespace

bool begins_scene(const std::filesystem::path& path) {
  return is_directory(path) || io::is_mesh_file(path) || lower_extension(path) == ".vdb";
}

Scene read_scene(const std::filesystem::path& file) {
  if (begins_scene(file)) {
    throw InputError(
        file.string() + ": is no scene; have a first scene of it written, and give that",
        {{"new_scene"}});
  }
  return scene_of({file, page, io::JsonComments::allowed}, file);
}

Scene read_scene(const std::string& text, const std::filesystem::path& file,
                 const std::string& which) {
  return scene_of(
      io::JsonDocument::of_text(text, file.string() + which, page, io::JsonComments::allowed),
      file);
}

std::vector<std::filesystem::path> files_of(const Scene& scene) {
  std::vector<std::filesystem::path> files{scene.file};
  for (const SceneObject& object : scene.objects) {
    if (const auto* mesh = std::get_if<std::filesystem::path>(&object.shape))
      files.push_back(*mesh);
    if (object.fitted_as) files.push_back(*object.fitted_as);
    add_files(object.material, files);
    if (object.polycube) files.push_back(*object.polycube);
    if (object.edits) files.push_back(*object.edits);
    const SurfaceDetail& detail = object.finish.detail;
    for (const auto& image : {detail.bump, detail.gloss, detail.reflectance_image}) {
      if (image) files.push_back(image->file);
    }
  }
  for (const Light& light : scene.lights) {
    if (const auto* projector = std::get_if<ProjectorLight>(&light)) {
      files.push_back(projector->image);
    }
    if (const auto* sky = std::get_if<EnvironmentLight>(&light); sky != nullptr && sky->image) {
      files.push_back(*sky->image);
    }
  }
  return files;
}

}  // namespace kappamu::render
