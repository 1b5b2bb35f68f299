#include "render/hair/fur_file.h"

#include <nlohmann/json.hpp>

#include "render/node_values.h"

namespace kappamu::render {

namespace {

using Node = io::JsonNode;
using nlohmann::ordered_json;

FurStroke read_stroke(const Node& node) {
  node.expect_fields({"brush", "points_mm", "radius_mm"}, {"amount", "colour"});
  FurStroke stroke;
  stroke.of = node["brush"].named(fur_brushes);
  for (const Node& point : node["points_mm"].items(2)) stroke.points_mm.push_back(point_of(point));
  stroke.radius_mm = length_of(node["radius_mm"]);
  const bool amount = stroke.of == FurStroke::Of::length || stroke.of == FurStroke::Of::density;
  const bool colour = stroke.of == FurStroke::Of::colour;
  for (const auto& [field, needed] : {std::pair("amount", amount), std::pair("colour", colour)}) {
    if (needed == node.has(field)) continue;
    node.fail(needed ? std::string("has no field '") + field + "'; add it"
                     : std::string("has a field '") + field + "' of another brush; remove it");
  }
  if (amount) stroke.amount = node["amount"].number_between(0.0, 1.0);
  if (colour) stroke.colour = colour_of(node["colour"], 1.0);
  return stroke;
}

std::vector<FurStroke> read_strokes(const Node& node) {
  std::vector<FurStroke> strokes;
  for (const Node& stroke : node.items(0)) strokes.push_back(read_stroke(stroke));
  return strokes;
}

std::string read_reflectance(const Node& node) {
  return node.choice({"kajiya-kay", "marschner", "even"});
}

ordered_json json_of(const Colour& colour) {
  return {colour[0], colour[1], colour[2]};
}

ordered_json json_of(const std::vector<FurStroke>& strokes) {
  ordered_json list = ordered_json::array();
  for (const FurStroke& stroke : strokes) {
    ordered_json points = ordered_json::array();
    for (const Eigen::Vector3d& at : stroke.points_mm) points.push_back({at.x(), at.y(), at.z()});
    ordered_json json{{"brush", kappamu::name_of(fur_brushes, stroke.of)},
                      {"points_mm", std::move(points)},
                      {"radius_mm", stroke.radius_mm}};
    if (stroke.of == FurStroke::Of::colour) json["colour"] = json_of(stroke.colour);
    if (stroke.of == FurStroke::Of::length || stroke.of == FurStroke::Of::density) {
      json["amount"] = stroke.amount;
    }
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace

Fur read_fur(const Node& node, const std::filesystem::path& folder) {
  node.expect_fields(
      {"length_mm"},
      {"tile_mm",       "width",       "density",    "curl",      "lean",        "comb",
       "comb_turn_deg", "root_colour", "tip_colour", "variation", "reflectance", "shine",
       "fins",          "bands",       "rays",       "seed",      "length_map",  "density_map",
       "colour_map",    "comb_map",    "strokes"});
  Fur fur;
  for (const FurNumber& number : fur_numbers) {
    if (!node.has(number.name)) continue;
    fur.*number.of = node[number.name].number_between(number.smallest, number.largest);
  }
  if (node.has("tile_mm")) {
    fur.tile_mm =
        node["tile_mm"].number_between(least_tile * fur.length_mm, largest_tile * fur.length_mm);
  }
  if (node.has("comb")) fur.comb = direction_of(node["comb"]);
  if (node.has("root_colour")) fur.root_colour = colour_of(node["root_colour"], 1.0);
  if (node.has("tip_colour")) fur.tip_colour = colour_of(node["tip_colour"], 1.0);
  if (node.has("reflectance")) fur.reflectance = read_reflectance(node["reflectance"]);
  if (node.has("fins")) fur.fins = node["fins"].flag();
  if (node.has("bands")) fur.bands = whole_number(node["bands"], 1, 6);
  if (node.has("rays")) fur.rays = whole_number(node["rays"], 16, 65536);
  if (node.has("seed")) {
    fur.seed = static_cast<std::uint64_t>(whole_number(node["seed"], 0, 1 << 30));
  }
  const auto map = [&](const char* field, std::optional<std::filesystem::path>& file) {
    if (node.has(field)) file = path_of(node[field], folder);
  };
  map("length_map", fur.length_map);
  map("density_map", fur.density_map);
  map("colour_map", fur.colour_map);
  map("comb_map", fur.comb_map);
  if (node.has("strokes")) fur.strokes = read_strokes(node["strokes"]);
  return fur;
}

FurChange read_fur_change(const Node& node) {
  std::vector<std::string_view> fields{"root_colour", "tip_colour", "reflectance", "strokes"};
  for (const FurNumber& number : fur_numbers) fields.push_back(number.name);
  node.expect_fields({}, fields);
  FurChange change;
  for (std::size_t i = 0; i < fur_number_count; ++i) {
    const FurNumber& number = fur_numbers[i];
    if (!node.has(number.name)) continue;
    change.numbers[i] = node[number.name].number_between(number.smallest, number.largest);
  }
  if (node.has("root_colour")) change.root_colour = colour_of(node["root_colour"], 1.0);
  if (node.has("tip_colour")) change.tip_colour = colour_of(node["tip_colour"], 1.0);
  if (node.has("reflectance")) change.reflectance = read_reflectance(node["reflectance"]);
  if (node.has("strokes")) change.strokes = read_strokes(node["strokes"]);
  if (change.empty()) node.fail("changes nothing; write a field of the fur, or 'strokes'");
  return change;
}

ordered_json json_of(const FurChange& change) {
  ordered_json json = ordered_json::object();
  for (std::size_t i = 0; i < fur_number_count; ++i) {
    if (change.numbers[i]) json[fur_numbers[i].name] = *change.numbers[i];
  }
  if (change.root_colour) json["root_colour"] = json_of(*change.root_colour);
  if (change.tip_colour) json["tip_colour"] = json_of(*change.tip_colour);
  if (change.reflectance) json["reflectance"] = *change.reflectance;
  if (!change.strokes.empty()) json["strokes"] = json_of(change.strokes);
  return json;
}

void put_changes(const Fur& fur, ordered_json& json) {
  for (const FurNumber& number : fur_numbers) json[number.name] = fur.*number.of;
  if (fur.tile_mm) json["tile_mm"] = *fur.tile_mm;
  json["root_colour"] = json_of(fur.root_colour);
  json["tip_colour"] = json_of(fur.tip_colour);
  json["reflectance"] = fur.reflectance;
  json.erase("strokes");
  if (!fur.strokes.empty()) json["strokes"] = json_of(fur.strokes);
}

}  // namespace kappamu::render
