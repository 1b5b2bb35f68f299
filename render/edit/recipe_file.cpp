// A recipe's file to Recipe and back: fields, types, bounds. Channels and images are checked where
// they are used (history.cpp, selection.cpp).
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/json_node.h"
#include "render/edit/edit.h"

namespace kappamu::render {

namespace {

using Node = io::JsonNode;
using Eigen::Vector3d;
using nlohmann::ordered_json;

constexpr double largest_mm = 1e6, smallest_mm = 1e-6;
constexpr double largest_factor = 1e6;

Vector3d vector_of(const Node& node) {
  const std::vector<Node> xyz = node.exactly(3);
  return {xyz[0].number_between(-largest_mm, largest_mm),
          xyz[1].number_between(-largest_mm, largest_mm),
          xyz[2].number_between(-largest_mm, largest_mm)};
}

double length_of(const Node& node) {
  return node.number_between(smallest_mm, largest_mm);
}

Vector3d direction_of(const Node& node) {
  const Vector3d direction = vector_of(node);
  if (direction.norm() < 1e-9) node.fail("has no length; write a direction");
  // A direction of unit length stays what it is to the last bit: a recipe replayed is the same.
  return std::abs(direction.norm() - 1.0) < 1e-12 ? direction : Vector3d(direction.normalized());
}

Face face_of(const Node& node) {
  return face_from_string(node.choice({"x-", "x+", "y-", "y+", "z-", "z+"}));
}

Stroke stroke_of(const Node& node) {
  node.expect_fields({"points_mm", "inward"});
  Stroke stroke;
  for (const Node& point : node["points_mm"].items(1)) {
    stroke.points_mm.push_back(vector_of(point));
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

Selection selection_of(const Node& node, const std::filesystem::path& folder) {
  if (!node.has("kind")) node.fail("has no field 'kind'; add it (docs/formats.md)");
  const std::string kind = node["kind"].choice({"all", "brush", "texture", "depth", "box"});
  if (kind == "brush") {
    node.expect_fields({"kind", "strokes", "radius_mm", "depth_mm"}, {"hardness", "stretch"});
    BrushSelection brush;
    for (const Node& stroke : node["strokes"].items(1)) brush.strokes.push_back(stroke_of(stroke));
    brush.radius_mm = length_of(node["radius_mm"]);
    brush.depth_mm = length_of(node["depth_mm"]);
    if (node.has("hardness")) brush.hardness = node["hardness"].number_between(0.0, 1.0);
    if (node.has("stretch")) {
      const std::vector<Node> xyz = node["stretch"].exactly(3);
      for (int axis = 0; axis < 3; ++axis) {
        brush.stretch[axis] = xyz[static_cast<std::size_t>(axis)].number_between(1e-6, 1e6);
      }
    }
    return brush;
  }
  if (kind == "texture") {
    node.expect_fields({"kind", "image", "face", "depth_mm"});
    TextureSelection texture;
    const std::string image = node["image"].text();
    if (image.empty()) node["image"].fail("is empty; write a file's name");
    texture.image = folder / image;
    texture.face = face_of(node["face"]);
    texture.depth_mm = length_of(node["depth_mm"]);
    return texture;
  }
  if (kind == "depth") {
    node.expect_fields({"kind", "from_mm", "to_mm"}, {"faces"});
    DepthSelection depth;
    depth.from_mm = node["from_mm"].number_between(0.0, largest_mm);
    depth.to_mm = length_of(node["to_mm"]);
    if (depth.to_mm <= depth.from_mm) {
      node["to_mm"].fail("is not beyond from_mm; write a larger depth");
    }
    if (node.has("faces")) {
      depth.faces.clear();
      for (const Node& face : node["faces"].items(1)) depth.faces.push_back(face_of(face));
    }
    return depth;
  }
  if (kind == "box") {
    node.expect_fields({"kind", "from_mm", "to_mm"});
    const BoxSelection box{vector_of(node["from_mm"]), vector_of(node["to_mm"])};
    if ((box.to_mm.array() <= box.from_mm.array()).any()) {
      node["to_mm"].fail("is not beyond from_mm on every axis; write the box's far corner");
    }
    return box;
  }
  node.expect_fields({"kind"});
  return WholeSelection{};
}

/// a of edit.h for each coefficient, within what its operation can mean.
void read_amounts(const Node& node, Edit& edit) {
  const auto amount = [&](const char* name, double largest) -> std::optional<double> {
    if (!node.has(name)) return std::nullopt;
    if (edit.operation == Operation::multiply)
      return node[name].number_between(0.0, largest_factor);
    if (edit.operation == Operation::add) return node[name].number_between(-largest, largest);
    return node[name].number_between(0.0, largest);
  };
  edit.kappa = amount("kappa", largest_kappa_mm);
  edit.mu = amount("mu", largest_mu_per_mm);
  if (!edit.kappa && !edit.mu) node.fail("changes nothing; write 'kappa', 'mu' or both");
  if (edit.kappa && *edit.kappa <= 0.0 && edit.operation != Operation::add) {
    node["kappa"].fail("is 0; write a positive number");
  }
}

Edit edit_of(const Node& node, const std::filesystem::path& folder) {
  if (!node.has("operation")) node.fail("has no field 'operation'; add it (docs/formats.md)");
  Edit edit;
  const std::string name = node["operation"].choice({"multiply", "add", "set", "blend", "copy"});
  for (const Operation operation :
       {Operation::multiply, Operation::add, Operation::set, Operation::blend, Operation::copy}) {
    if (to_string(operation) == name) edit.operation = operation;
  }
  if (edit.operation == Operation::copy) {
    node.expect_fields({"operation", "where", "offset_mm"}, {"channels"});
    edit.offset_mm = vector_of(node["offset_mm"]);
  } else if (edit.operation == Operation::blend) {
    node.expect_fields({"operation", "where", "share"}, {"channels", "kappa", "mu"});
    edit.share = node["share"].number_between(0.0, 1.0);
    read_amounts(node, edit);
  } else {
    node.expect_fields({"operation", "where"}, {"channels", "kappa", "mu"});
    read_amounts(node, edit);
  }
  if (node.has("channels")) {
    for (const Node& channel : node["channels"].items(1)) edit.channels.push_back(channel.text());
  }
  edit.where = selection_of(node["where"], folder);
  return edit;
}

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

ordered_json json_of(const BrushSelection& where, const std::filesystem::path& /*folder*/) {
  ordered_json strokes = ordered_json::array();
  for (const Stroke& stroke : where.strokes) {
    strokes.push_back(
        {{"points_mm", json_of(stroke.points_mm)}, {"inward", json_of(stroke.inward)}});
  }
  return {{"kind", "brush"},
          {"strokes", std::move(strokes)},
          {"radius_mm", where.radius_mm},
          {"depth_mm", where.depth_mm},
          {"hardness", where.hardness},
          {"stretch", json_of(where.stretch)}};
}

ordered_json json_of(const TextureSelection& where, const std::filesystem::path& folder) {
  return {{"kind", "texture"},
          {"image", std::filesystem::proximate(where.image, folder).string()},
          {"face", to_string(where.face)},
          {"depth_mm", where.depth_mm}};
}

ordered_json json_of(const DepthSelection& where, const std::filesystem::path& /*folder*/) {
  ordered_json faces = ordered_json::array();
  for (const Face face : where.faces) faces.push_back(to_string(face));
  return {{"kind", "depth"},
          {"from_mm", where.from_mm},
          {"to_mm", where.to_mm},
          {"faces", std::move(faces)}};
}

ordered_json json_of(const BoxSelection& where, const std::filesystem::path& /*folder*/) {
  return {{"kind", "box"}, {"from_mm", json_of(where.from_mm)}, {"to_mm", json_of(where.to_mm)}};
}

ordered_json json_of(const Edit& edit, const std::filesystem::path& folder) {
  ordered_json json{{"operation", to_string(edit.operation)}};
  if (edit.operation == Operation::copy) json["offset_mm"] = json_of(edit.offset_mm);
  if (edit.operation == Operation::blend) json["share"] = edit.share;
  if (edit.kappa) json["kappa"] = *edit.kappa;
  if (edit.mu) json["mu"] = *edit.mu;
  if (!edit.channels.empty()) json["channels"] = edit.channels;
  json["where"] = std::visit([&](const auto& where) { return json_of(where, folder); }, edit.where);
  return json;
}

}  // namespace

std::string to_string(Operation operation) {
  switch (operation) {
    case Operation::multiply:
      return "multiply";
    case Operation::add:
      return "add";
    case Operation::set:
      return "set";
    case Operation::blend:
      return "blend";
    case Operation::copy:
      break;
  }
  return "copy";
}

Recipe read_recipe(const std::filesystem::path& file) {
  const io::JsonDocument document(file, "docs/formats.md", io::JsonComments::allowed);
  const Node root = document.root();
  root.expect_fields({"format", "version", "edits"});
  root.expect_format("kappamu-edit");
  Recipe recipe;
  for (const Node& node : root["edits"].items(0)) {
    recipe.edits.push_back(edit_of(node, file.parent_path()));
  }
  return recipe;
}

void require_valid(const Edit& edit) {
  const std::filesystem::path folder = std::filesystem::current_path();
  const io::JsonDocument document =
      io::JsonDocument::of_text(json_of(edit, folder).dump(), "this edit", "docs/formats.md");
  edit_of(document.root(), folder);
}

std::string recipe_json(const Recipe& recipe, const std::filesystem::path& folder) {
  ordered_json edits = ordered_json::array();
  for (const Edit& edit : recipe.edits) edits.push_back(json_of(edit, folder));
  const ordered_json json{{"format", "kappamu-edit"}, {"version", 1}, {"edits", std::move(edits)}};
  return json.dump(2) + "\n";
}

}  // namespace kappamu::render
