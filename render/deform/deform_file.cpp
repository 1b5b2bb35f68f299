// Which fields a kind has is stated here alone.
#include "render/deform/deform_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace kappamu::render {

namespace {

using Node = io::JsonNode;
using nlohmann::ordered_json;

constexpr double largest_mm = 1e6, smallest_mm = 1e-6;

Eigen::Vector3d point_of(const Node& node) {
  const std::vector<Node> xyz = node.exactly(3);
  return {xyz[0].number_between(-largest_mm, largest_mm),
          xyz[1].number_between(-largest_mm, largest_mm),
          xyz[2].number_between(-largest_mm, largest_mm)};
}

double length_of(const Node& node) {
  return node.number_between(smallest_mm, largest_mm);
}

Eigen::Vector3d direction_of(const Node& node) {
  const Eigen::Vector3d direction = point_of(node);
  if (direction.norm() < 1e-9) node.fail("has no length; write a direction");
  // One of unit length stays what it is to the last bit: what is replayed is the same.
  return std::abs(direction.norm() - 1.0) < 1e-12 ? direction
                                                  : Eigen::Vector3d(direction.normalized());
}

ordered_json json_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

struct KindFields {
  std::vector<std::string_view> required, optional;
};

KindFields fields_of(DeformKind kind) {
  switch (kind) {
    case DeformKind::pull:
      return {{"axis", "brush"}, {}};
    case DeformKind::dent:
      return {{"brush"}, {}};
    case DeformKind::twist:
      return {{}, {"axis", "centre_mm", "length_mm", "brush"}};
    case DeformKind::bend:
      return {{}, {"axis", "towards", "centre_mm", "length_mm", "brush"}};
    case DeformKind::inflate:
      return {{}, {"brush"}};
    case DeformKind::noise:
      return {{"wavelength_mm"}, {"offset_mm", "seed", "brush"}};
    case DeformKind::scale:
      break;
  }
  return {{}, {"axis", "centre_mm", "brush"}};
}

DeformBrush read_brush(const Node& node) {
  node.expect_fields({"centre_mm", "radius_mm"}, {"edge"});
  DeformBrush brush{point_of(node["centre_mm"]), length_of(node["radius_mm"])};
  if (node.has("edge")) brush.edge = node["edge"].number_between(0.0, 1.0);
  return brush;
}

Deformation read_deformation(const Node& node) {
  if (!node.has("kind")) node.fail("has no field 'kind'; add it (docs/scene.md)");
  Deformation deformation;
  deformation.kind = node["kind"].named(deform_kinds);
  const DeformAmount amount = amount_of(deformation.kind);
  KindFields fields = fields_of(deformation.kind);
  fields.required.insert(fields.required.begin(), {"kind", amount.name});
  node.expect_fields(fields.required, fields.optional);
  deformation.amount = node[amount.name].number_between(amount.least, amount.most);
  if (node.has("axis")) deformation.axis = direction_of(node["axis"]);
  if (node.has("towards")) deformation.towards = direction_of(node["towards"]);
  if (node.has("centre_mm")) deformation.centre_mm = point_of(node["centre_mm"]);
  if (node.has("length_mm")) deformation.length_mm = length_of(node["length_mm"]);
  if (node.has("wavelength_mm")) deformation.wavelength_mm = length_of(node["wavelength_mm"]);
  if (node.has("offset_mm")) deformation.offset_mm = point_of(node["offset_mm"]);
  if (node.has("seed")) deformation.seed = node["seed"].whole();
  if (node.has("brush")) deformation.brush = read_brush(node["brush"]);
  const Eigen::Vector3d axis = deformation.axis.value_or(Eigen::Vector3d::UnitY());
  if (deformation.kind == DeformKind::bend && axis.cross(deformation.towards).norm() < 1e-6) {
    node.fail("bends along its axis; write a 'towards' across the axis");
  }
  return deformation;
}

ordered_json json_of(const Deformation& deformation) {
  ordered_json json{{"kind", name_of(deform_kinds, deformation.kind)},
                    {amount_of(deformation.kind).name, deformation.amount}};
  const KindFields fields = fields_of(deformation.kind);
  const auto add = [&](const char* name, bool stated, const ordered_json& value) {
    const bool required = std::count(fields.required.begin(), fields.required.end(), name) > 0;
    const bool known = std::count(fields.optional.begin(), fields.optional.end(), name) > 0;
    if (required || (known && stated)) json[name] = value;
  };
  const Deformation usual;
  add("axis", deformation.axis.has_value(),
      json_of(deformation.axis.value_or(Eigen::Vector3d::UnitY())));
  add("towards", true, json_of(deformation.towards));
  add("centre_mm", deformation.centre_mm != usual.centre_mm, json_of(deformation.centre_mm));
  add("length_mm", deformation.length_mm.has_value(), deformation.length_mm.value_or(0.0));
  add("wavelength_mm", true, deformation.wavelength_mm);
  add("offset_mm", deformation.offset_mm != usual.offset_mm, json_of(deformation.offset_mm));
  add("seed", deformation.seed != usual.seed, deformation.seed);
  if (!deformation.brush) return json;
  const DeformBrush& brush = *deformation.brush;
  json["brush"] = {{"centre_mm", json_of(brush.centre_mm)},
                   {"radius_mm", brush.radius_mm},
                   {"edge", brush.edge}};
  return json;
}

}  // namespace

nlohmann::ordered_json deformations_json(std::span<const Deformation> deformations) {
  ordered_json list = ordered_json::array();
  for (const Deformation& one : deformations) list.push_back(json_of(one));
  return list;
}

std::vector<Deformation> read_deformations(const Node& node) {
  std::vector<Deformation> deformations;
  for (const Node& one : node.items(0)) deformations.push_back(read_deformation(one));
  return deformations;
}

}  // namespace kappamu::render
