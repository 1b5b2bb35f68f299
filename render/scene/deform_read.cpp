// The list "deform" of a scene's object: which fields a kind has is stated here alone.
#include <Eigen/Geometry>

#include "render/scene/node_values.h"

namespace kappamu::render {

namespace {

using Node = io::JsonNode;

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

}  // namespace

std::vector<Deformation> read_deformations(const Node& node) {
  std::vector<Deformation> deformations;
  for (const Node& one : node.items(0)) deformations.push_back(read_deformation(one));
  return deformations;
}

}  // namespace kappamu::render
