#include "app/edit/edited_scene.h"

#include <nlohmann/json.hpp>

#include "forward/registry.h"
#include "io/read_file.h"
#include "pipeline/output_folder.h"

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

/// The material's own placing stays, but that of a shell, which is now over the object's box.
ordered_json measured(const ordered_json& before) {
  if (!before.contains("volume") || before.value("placement", "") == "shell") {
    return {{"volume", "volume.vdb"}};
  }
  ordered_json json = before;
  json["volume"] = "volume.vdb";
  return json;
}

}  // namespace

std::string edited_scene(const render::Scene& scene, std::size_t object,
                         const render::EditedObject& edited, const fs::path& folder) {
  ordered_json json = ordered_json::parse(io::read_text(scene.file));
  const fs::path from = pipeline::canonical_path(scene.file).parent_path();
  const auto move = [&](ordered_json& in, const char* field) {
    if (!in.contains(field)) return;
    const fs::path file = pipeline::canonical_path(from / in[field].get<std::string>());
    in[field] = file.lexically_relative(folder).string();
  };
  for (ordered_json& one : json["objects"]) {
    for (const char* field : {"mesh", "polycube", "edits"}) move(one, field);
    move(one["material"], "volume");
  }
  for (ordered_json& light : json["lights"]) move(light, "image");

  ordered_json& changed = json["objects"][object];
  changed.erase("edits");
  const auto material = edited.homogeneous();
  changed["material"] = material ? homogeneous(*material) : measured(changed["material"]);
  const render::EditHistory& history = edited.history();
  // Coefficients in place of a name state no index.
  const std::optional<double> eta = material ? history.volume().eta : history.eta();
  if (eta) changed["surface"]["eta"] = *eta;
  if (history.roughness()) changed["surface"]["roughness"] = *history.roughness();
  if (!material && !forward::object_model(scene.model.name).can.heterogeneous) {
    json["model"] = {{"name", "embedded"}, {"tolerance", scene.model.tolerance}};
  }
  return json.dump(2) + "\n";
}

}  // namespace kappamu::app
