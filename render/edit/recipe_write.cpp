// A recipe to its file's text, to the last bit.
#include <nlohmann/json.hpp>

#include "render/deform/deform_file.h"
#include "render/edit/recipe_fields.h"
#include "render/hair/fur_file.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;
using nlohmann::ordered_json;

ordered_json json_of(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

ordered_json json_of(const std::vector<Vector3d>& vectors) {
  ordered_json list = ordered_json::array();
  for (const Vector3d& v : vectors) list.push_back(json_of(v));
  return list;
}

ordered_json json_of(const WholeSelection& /*where*/, const std::filesystem::path& /*folder*/) {
  return {{"kind", "all"}};
}

/// The volume's frame is what a recipe means that states none.
ordered_json with(Frame frame, ordered_json json) {
  if (frame == Frame::object) json["frame"] = "object";
  return json;
}

std::string json_of(const std::filesystem::path& file, const std::filesystem::path& folder) {
  return std::filesystem::proximate(file, folder).string();
}

ordered_json json_of(const BrushSelection& where, const std::filesystem::path& /*folder*/) {
  ordered_json strokes = ordered_json::array();
  for (const Stroke& stroke : where.strokes) {
    strokes.push_back(
        {{"points_mm", json_of(stroke.points_mm)}, {"inward", json_of(stroke.inward)}});
  }
  ordered_json json{{"kind", "brush"},
                    {"strokes", std::move(strokes)},
                    {"radius_mm", where.radius_mm},
                    {"depth_mm", where.depth_mm},
                    {"hardness", where.hardness}};
  if (where.frame == Frame::volume) json["stretch"] = json_of(where.stretch);
  return with(where.frame, json);
}

ordered_json json_of(const TextureSelection& where, const std::filesystem::path& folder) {
  return {{"kind", "texture"},
          {"image", json_of(where.image, folder)},
          {"face", to_string(where.face)},
          {"depth_mm", where.depth_mm}};
}

ordered_json json_of(const ProjectionSelection& where, const std::filesystem::path& folder) {
  return {{"kind", "projection"},
          {"image", json_of(where.image, folder)},
          {"position_mm", json_of(where.position_mm)},
          {"target_mm", json_of(where.target_mm)},
          {"up", json_of(where.up)},
          {"fov_deg", where.fov_deg},
          {"from_mm", where.from_mm},
          {"to_mm", where.to_mm}};
}

ordered_json json_of(const CoordinatesSelection& where, const std::filesystem::path& folder) {
  return {{"kind", "coordinates"},
          {"image", json_of(where.image, folder)},
          {"from_mm", where.from_mm},
          {"to_mm", where.to_mm}};
}

ordered_json json_of(const DepthSelection& where, const std::filesystem::path& /*folder*/) {
  ordered_json json{{"kind", "depth"}, {"from_mm", where.from_mm}, {"to_mm", where.to_mm}};
  if (where.frame == Frame::volume) {
    json["faces"] = ordered_json::array();
    for (const Face face : where.faces) json["faces"].push_back(to_string(face));
  }
  return with(where.frame, json);
}

ordered_json json_of(const BoxSelection& where, const std::filesystem::path& /*folder*/) {
  return with(
      where.frame,
      {{"kind", "box"}, {"from_mm", json_of(where.from_mm)}, {"to_mm", json_of(where.to_mm)}});
}

}  // namespace

ordered_json edit_json(const Edit& edit, const std::filesystem::path& folder) {
  ordered_json json{{"operation", kappamu::name_of(operation_names, edit.operation)}};
  if (edit.off) json["off"] = true;
  if (edit.eta) json["eta"] = *edit.eta;
  if (edit.roughness) json["roughness"] = *edit.roughness;
  if (edit.operation == Operation::deform) json["deform"] = deformations_json(edit.deformations);
  if (edit.instead) json["instead"] = true;
  if (edit.operation == Operation::fur) json["fur"] = json_of(edit.fur);
  if (!edit.of_medium()) return json;
  if (edit.operation == Operation::copy) json["offset_mm"] = json_of(edit.offset_mm);
  if (!edit.volume.empty()) json["volume"] = json_of(edit.volume, folder);
  if (edit.operation == Operation::blend) json["share"] = edit.share;
  for (const Range& range : ranges) {
    const Amount& amount = edit.*range.amount;
    if (amount.size() == 1) json[range.name] = amount[0];
    if (amount.size() > 1) json[range.name] = amount;
  }
  if (!edit.published.empty()) json["published"] = edit.published;
  if (!edit.channels.empty()) json["channels"] = edit.channels;
  json["where"] = std::visit([&](const auto& where) { return json_of(where, folder); }, edit.where);
  return json;
}

ordered_json fields_of(const LightChange& change) {
  ordered_json json = nlohmann::ordered_json::object();
  const auto put = [&](const char* field, const std::optional<Vector3d>& value) {
    if (value) json[field] = {value->x(), value->y(), value->z()};
  };
  put("position_mm", change.position_mm);
  put("direction", change.direction);
  if (change.turn_deg) json["turn_deg"] = *change.turn_deg;
  put("irradiance", change.irradiance);
  put("radiance", change.radiance);
  return json;
}

std::string recipe_json(const Recipe& recipe, const std::filesystem::path& folder) {
  ordered_json edits = ordered_json::array();
  for (const Edit& edit : recipe.edits) edits.push_back(edit_json(edit, folder));
  ordered_json json{{"format", "kappamu-edit"}, {"version", 1}};
  if (recipe.voxel_mm) json["voxel_mm"] = *recipe.voxel_mm;
  json["edits"] = std::move(edits);
  for (const LightChange& change : recipe.lights) {
    ordered_json light{{"light", change.light + 1}};
    light.update(fields_of(change));
    json["lights"].push_back(std::move(light));
  }
  return json.dump(2) + "\n";
}

}  // namespace kappamu::render
