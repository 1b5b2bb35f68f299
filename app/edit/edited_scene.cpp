#include "app/edit/edited_scene.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "forward/registry.h"
#include "io/read_file.h"
#include "pipeline/output_folder.h"
#include "render/deform/deform_file.h"
#include "render/hair/fur_file.h"

namespace kappamu::app {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

ordered_json json_of(const render::Colour& colour) {
  return {colour[0], colour[1], colour[2]};
}

ordered_json homogeneous(const render::HomogeneousMaterial& material) {
  ordered_json json{{"kappa_mm", json_of(material.kappa_mm)},
                    {"mu_per_mm", json_of(material.mu_per_mm)}};
  if (!material.source.empty()) json["source"] = material.source + ", edited";
  return json;
}

/// Its own placing stays of a volume that lies in the object as a solid. A homogeneous material's
/// volume is stretched to the object's box; that of a shell or a composed material lies at its true
/// scale.
ordered_json measured(const ordered_json& before, const render::SceneObject& object,
                      const render::EditedObject& edited) {
  ordered_json json{{"volume", "volume.vdb"}};
  if (std::holds_alternative<render::HomogeneousMaterial>(object.material)) return json;
  const auto* volume = std::get_if<render::VolumeMaterial>(&object.material);
  if (volume != nullptr && volume->placement != render::VolumeMaterial::Placement::shell) {
    json = before;
    json["volume"] = "volume.vdb";
    return json;
  }
  const GridShape& shape = edited.history().volume().shape();
  const Eigen::Vector3d middle =
      edited.placing().object_from_volume *
      Eigen::Vector3d(0.5 * shape.voxel_mm * Eigen::Vector3d(shape.nx, shape.ny, shape.nz));
  json["placement"] = "repeat";
  json["offset_mm"] = {middle.x(), middle.y(), middle.z()};
  return json;
}

/// Fields of objects, materials and lights that name a file.
bool names_file(const std::string& field) {
  constexpr std::array fields{"mesh", "fitted_as",  "polycube",    "edits",      "volume",  "image",
                              "file", "length_map", "density_map", "colour_map", "comb_map"};
  return std::find(fields.begin(), fields.end(), field) != fields.end();
}

/// Names of files relative to `from` made relative to `folder`.
void move_files(ordered_json& json, const fs::path& from, const fs::path& folder) {
  for (auto& [field, value] : json.items()) {
    if (value.is_structured()) {
      move_files(value, from, folder);
    } else if (value.is_string() && json.is_object() && names_file(field)) {
      const fs::path file = pipeline::canonical_path(from / value.get<std::string>());
      value = file.lexically_relative(folder).string();
    }
  }
}

bool edits_fur(const render::EditHistory& history) {
  return std::any_of(history.list().begin(), history.list().end(),
                     [](const auto& edit) { return edit->operation == render::Operation::fur; });
}

}  // namespace

std::string edited_scene(const render::Scene& scene, std::size_t object,
                         const render::EditedObject& edited, const fs::path& folder) {
  ordered_json json = ordered_json::parse(io::read_text(scene.file));
  const fs::path from = pipeline::canonical_path(scene.file).parent_path();
  move_files(json["objects"], from, folder);
  move_files(json["lights"], from, folder);

  ordered_json& changed = json["objects"][object];
  changed.erase("edits");
  const auto material = edited.homogeneous();
  changed["material"] = material ? homogeneous(*material)
                                 : measured(changed["material"], scene.objects[object], edited);
  const render::EditHistory& history = edited.history();
  const std::vector<render::Deformation> deformations = history.deformations();
  changed.erase("deform");
  if (!deformations.empty()) changed["deform"] = render::deformations_json(deformations);
  if (std::optional<render::Fur> fur = scene.objects[object].fur;
      fur && (scene.objects[object].edits || edits_fur(history))) {
    history.change(*fur);
    render::put_changes(*fur, changed["fur"]);
  }
  // Coefficients in place of a name state no index.
  const std::optional<double> eta = material ? history.volume().eta : history.eta();
  if (eta) changed["surface"]["eta"] = *eta;
  if (history.roughness()) changed["surface"]["roughness"] = *history.roughness();
  if (!material && !forward::object_model(scene.model.name).can.heterogeneous) {
    json["model"] = {{"name", "embedded"}, {"tolerance", scene.model.tolerance}};
  }
  render::LightChanges lights;
  if (const auto& own = scene.objects[object].edits) lights = render::read_recipe(*own).lights;
  const render::LightChanges later = edited.recipe().lights;
  for (std::size_t other = 0; other < scene.objects.size(); ++other) {
    const auto& recipe = scene.objects[other].edits;
    if (other == object || !recipe) continue;
    // The scene written has this recipe still, which would undo the change.
    render::expect_agreement(render::read_recipe(*recipe).lights, recipe->string(), later,
                             "the edits of object '" + scene.objects[object].name + "'");
  }
  lights.insert(lights.end(), later.begin(), later.end());
  for (const render::LightChange& change : lights) {
    json["lights"].at(change.light).update(render::fields_of(change));
  }
  return json.dump(2) + "\n";
}

}  // namespace kappamu::app
