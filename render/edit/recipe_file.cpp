// A recipe's file to Recipe: fields, types, bounds. Channels and images are checked where
// they are used (history.cpp, selection.cpp).
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/json_node.h"
#include "render/deform/deform_file.h"
#include "render/edit/recipe_fields.h"
#include "render/hair/fur_file.h"
#include "render/material/published_materials.h"
#include "render/node_values.h"

namespace kappamu::render {

namespace {

using Node = io::JsonNode;
using Eigen::Vector3d;

constexpr double largest_factor = 1e6;

constexpr Names<Frame, 2> frame_names{{{"volume", Frame::volume}, {"object", Frame::object}}};

Frame frame_of(const Node& node) {
  return node.has("frame") ? node["frame"].named(frame_names) : Frame::volume;
}

/// The range of depths of a selection.
template <class Where>
void read_depths(const Node& node, Where& where) {
  where.from_mm = node["from_mm"].number_between(0.0, largest_mm);
  where.to_mm = length_of(node["to_mm"]);
  if (where.to_mm <= where.from_mm) {
    node["to_mm"].fail("is not beyond from_mm; write a larger depth");
  }
}

Face face_of(const Node& node) {
  return face_from_string(node.choice({"x-", "x+", "y-", "y+", "z-", "z+"}));
}

Stroke stroke_of(const Node& node) {
  node.expect_fields({"points_mm", "inward"});
  Stroke stroke;
  for (const Node& point : node["points_mm"].items(1)) {
    stroke.points_mm.push_back(point_of(point));
  }
  for (const Node& direction : node["inward"].items(1)) {
    stroke.inward.push_back(direction_of(direction));
  }
  if (stroke.inward.size() != 1 && stroke.inward.size() != stroke.points_mm.size()) {
    node["inward"].fail("has " + std::to_string(stroke.inward.size()) + " directions for " +
                        std::to_string(stroke.points_mm.size()) +
                        " points; write one for all or one each");
  }
  return stroke;
}

BrushSelection brush_of(const Node& node) {
  node.expect_fields({"kind", "strokes", "radius_mm", "depth_mm"},
                     {"hardness", "stretch", "frame"});
  BrushSelection brush;
  brush.frame = frame_of(node);
  for (const Node& stroke : node["strokes"].items(1)) brush.strokes.push_back(stroke_of(stroke));
  brush.radius_mm = length_of(node["radius_mm"]);
  brush.depth_mm = length_of(node["depth_mm"]);
  if (node.has("hardness")) brush.hardness = node["hardness"].number_between(0.0, 1.0);
  if (node.has("stretch")) {
    if (brush.frame == Frame::object) {
      node["stretch"].fail("belongs to the volume's frame; remove it");
    }
    brush.stretch = three_of(node["stretch"], 1e-6, 1e6);
  }
  return brush;
}

ProjectionSelection projection_of(const Node& node, const std::filesystem::path& folder) {
  node.expect_fields({"kind", "image", "position_mm", "target_mm", "fov_deg", "from_mm", "to_mm"},
                     {"up"});
  ProjectionSelection projection;
  projection.image = path_of(node["image"], folder);
  projection.position_mm = point_of(node["position_mm"]);
  projection.target_mm = point_of(node["target_mm"]);
  const Vector3d forward = projection.target_mm - projection.position_mm;
  if (forward.norm() < smallest_mm) {
    node["target_mm"].fail("lies at position_mm; move one of the two");
  }
  if (node.has("up")) projection.up = direction_of(node["up"]);
  if (projection.up.cross(forward.normalized()).norm() < 1e-6) {
    node.fail("looks along its 'up'; write an 'up' across the line to target_mm");
  }
  projection.fov_deg = node["fov_deg"].number_between(0.01, 170.0);
  read_depths(node, projection);
  return projection;
}

DepthSelection depth_of(const Node& node) {
  node.expect_fields({"kind", "from_mm", "to_mm"}, {"faces", "frame"});
  DepthSelection depth;
  depth.frame = frame_of(node);
  read_depths(node, depth);
  if (!node.has("faces")) return depth;
  if (depth.frame == Frame::object) node["faces"].fail("belongs to the volume's frame; remove it");
  depth.faces.clear();
  for (const Node& face : node["faces"].items(1)) depth.faces.push_back(face_of(face));
  return depth;
}

Selection selection_of(const Node& node, const std::filesystem::path& folder) {
  if (!node.has("kind")) node.fail("has no field 'kind'; add it (docs/formats.md)");
  const std::string kind =
      node["kind"].choice({"all", "brush", "texture", "projection", "coordinates", "depth", "box"});
  if (kind == "brush") return brush_of(node);
  if (kind == "projection") return projection_of(node, folder);
  if (kind == "coordinates") {
    node.expect_fields({"kind", "image", "from_mm", "to_mm"});
    CoordinatesSelection coordinates;
    coordinates.image = path_of(node["image"], folder);
    read_depths(node, coordinates);
    return coordinates;
  }
  if (kind == "depth") return depth_of(node);
  if (kind == "texture") {
    node.expect_fields({"kind", "image", "face", "depth_mm"});
    return TextureSelection{path_of(node["image"], folder), face_of(node["face"]),
                            length_of(node["depth_mm"])};
  }
  if (kind == "box") {
    node.expect_fields({"kind", "from_mm", "to_mm"}, {"frame"});
    const BoxSelection box{point_of(node["from_mm"]), point_of(node["to_mm"]), frame_of(node)};
    if ((box.to_mm.array() <= box.from_mm.array()).any()) {
      node["to_mm"].fail("is not beyond from_mm on every axis; write the box's far corner");
    }
    return box;
  }
  node.expect_fields({"kind"});
  return WholeSelection{};
}

double amount_of(const Node& node, const Range& range, Operation operation) {
  if (operation == Operation::add) return node.number_between(-range.largest, range.largest);
  if (operation != Operation::multiply && range.name != std::string("kappa")) {
    return node.number_between(range.smallest, range.largest);
  }
  const double value =
      node.number_between(0.0, operation == Operation::multiply ? largest_factor : range.largest);
  if (value <= 0.0 && range.smallest > 0.0) node.fail("is 0; write a positive number");
  return value;
}

/// a of edit.h for each coefficient, within what its operation can mean.
void read_amounts(const Node& node, Edit& edit) {
  int stated = 0;
  for (const Range& range : ranges) {
    if (!node.has(range.name)) continue;
    ++stated;
    const Node amount = node[range.name];
    if (amount.is_number()) {
      edit.*range.amount = {amount_of(amount, range, edit.operation)};
      continue;
    }
    for (const Node& one : amount.items(1)) {
      (edit.*range.amount).push_back(amount_of(one, range, edit.operation));
    }
    if (!edit.channels.empty() && (edit.*range.amount).size() != edit.channels.size()) {
      amount.fail("has " + std::to_string((edit.*range.amount).size()) + " numbers for " +
                  std::to_string(edit.channels.size()) + " channels; write one for each");
    }
  }
  if (node.has("published")) {
    if (stated > 0) node["published"].fail("states kappa and mu; write either it or numbers");
    edit.published = node["published"].one_of(published_material_names());
    return;
  }
  if (stated == 0) {
    node.fail("changes nothing; write 'kappa', 'mu' or both, or 'albedo', 'mean_free_path_mm'");
  }
  if ((node.has("kappa") || node.has("mu")) &&
      (node.has("albedo") || node.has("mean_free_path_mm"))) {
    node.fail("states both kappa or mu and albedo or mean_free_path_mm; keep one of the pairs");
  }
}

void read_surface(const Node& node, Edit& edit) {
  node.expect_fields({"operation"}, {"off", "eta", "roughness"});
  if (node.has("eta")) edit.eta = node["eta"].number_between(1.0, 4.0);
  if (node.has("roughness")) edit.roughness = node["roughness"].number_between(0.0, 1.0);
  if (!edit.eta && !edit.roughness) node.fail("changes nothing; write 'eta', 'roughness' or both");
}

void read_shape(const Node& node, Edit& edit) {
  node.expect_fields({"operation", "deform"}, {"off", "instead"});
  edit.deformations = read_deformations(node["deform"]);
  if (node.has("instead")) edit.instead = node["instead"].flag();
  if (edit.deformations.empty() && !edit.instead) {
    node["deform"].fail("changes nothing; write a deformation, or \"instead\": true");
  }
}

Edit edit_of(const Node& node, const std::filesystem::path& folder) {
  if (!node.has("operation")) node.fail("has no field 'operation'; add it (docs/formats.md)");
  Edit edit;
  edit.operation = node["operation"].named(operation_names);
  if (node.has("off")) edit.off = node["off"].flag();
  if (edit.operation == Operation::surface) {
    read_surface(node, edit);
    return edit;
  }
  if (edit.operation == Operation::deform) {
    read_shape(node, edit);
    return edit;
  }
  if (edit.operation == Operation::fur) {
    node.expect_fields({"operation", "fur"}, {"off"});
    edit.fur = read_fur_change(node["fur"]);
    return edit;
  }
  if (node.has("channels")) {
    for (const Node& channel : node["channels"].items(1)) edit.channels.push_back(channel.text());
  }
  std::vector<std::string_view> optional{"channels", "off"}, required{"operation", "where"};
  if (edit.operation == Operation::copy) {
    required.push_back("offset_mm");
    optional.push_back("volume");
  } else {
    for (const Range& range : ranges) optional.push_back(range.name);
  }
  if (edit.operation == Operation::blend) required.push_back("share");
  if (edit.operation == Operation::blend || edit.operation == Operation::set) {
    optional.push_back("published");
  }
  node.expect_fields(required, optional);
  if (edit.operation == Operation::copy) {
    edit.offset_mm = point_of(node["offset_mm"]);
    if (node.has("volume")) edit.volume = path_of(node["volume"], folder);
  } else {
    read_amounts(node, edit);
  }
  if (edit.operation == Operation::blend) edit.share = node["share"].number_between(0.0, 1.0);
  edit.where = selection_of(node["where"], folder);
  return edit;
}

LightChange light_change_of(const Node& node) {
  constexpr int most_lights = 10'000;
  node.expect_fields({"light"}, {"position_mm", "direction", "turn_deg", "irradiance", "radiance"});
  LightChange change;
  const int number = node["light"].integer();
  if (number < 1 || number > most_lights) {
    node["light"].fail("is " + std::to_string(number) + "; count the scene's lights from 1");
  }
  change.light = static_cast<std::size_t>(number - 1);
  if (node.has("position_mm")) change.position_mm = point_of(node["position_mm"]);
  if (node.has("direction")) change.direction = direction_of(node["direction"]);
  if (node.has("turn_deg")) change.turn_deg = node["turn_deg"].number_between(-360.0, 360.0);
  if (node.has("irradiance")) change.irradiance = three_of(node["irradiance"], 0.0, largest_light);
  if (node.has("radiance")) change.radiance = three_of(node["radiance"], 0.0, largest_light);
  if (change.empty()) node.fail("changes nothing; write 'position_mm' or another of its fields");
  return change;
}

}  // namespace

bool Edit::of_object() const {
  return std::visit(
      [](const auto& kind) {
        if constexpr (requires { kind.frame; }) return kind.frame == Frame::object;
        using Kind = std::decay_t<decltype(kind)>;
        return std::is_same_v<Kind, ProjectionSelection> ||
               std::is_same_v<Kind, CoordinatesSelection>;
      },
      where);
}

std::vector<std::filesystem::path> files_of(const Recipe& recipe) {
  std::vector<std::filesystem::path> files;
  for (const Edit& edit : recipe.edits) {
    if (!edit.volume.empty()) files.push_back(edit.volume);
    std::visit(
        [&](const auto& kind) {
          if constexpr (requires { kind.image; }) files.push_back(kind.image);
        },
        edit.where);
  }
  return files;
}

Recipe read_recipe(const std::filesystem::path& file) {
  const io::JsonDocument document(file, "docs/formats.md", io::JsonComments::allowed);
  const Node root = document.root();
  root.expect_fields({"format", "version", "edits"}, {"voxel_mm", "lights"});
  root.expect_format("kappamu-edit");
  Recipe recipe;
  if (root.has("voxel_mm")) recipe.voxel_mm = length_of(root["voxel_mm"]);
  for (const Node& node : root["edits"].items(0)) {
    recipe.edits.push_back(edit_of(node, file.parent_path()));
  }
  if (!root.has("lights")) return recipe;
  for (const Node& node : root["lights"].items(0)) {
    recipe.lights.push_back(light_change_of(node));
  }
  return recipe;
}

void require_valid(const Edit& edit) {
  const std::filesystem::path folder = std::filesystem::current_path();
  const io::JsonDocument document =
      io::JsonDocument::of_text(edit_json(edit, folder).dump(), "this edit", "docs/formats.md");
  edit_of(document.root(), folder);
}

}  // namespace kappamu::render
