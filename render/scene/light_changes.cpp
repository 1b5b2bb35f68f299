// From the lights of a scene to those lights turned, moved and coloured, and back.

#include <type_traits>

#include "core/error.h"
#include "render/scene/scene.h"

namespace kappamu::render {

using Eigen::Vector3d;

namespace {

/// A light's fields that a person changes; nullptr: it does not have it.
struct ChangeableFields {
  Vector3d *position_mm = nullptr, *direction = nullptr;
  double* turn_deg = nullptr;
  Colour *irradiance = nullptr, *radiance = nullptr;
};

ChangeableFields fields_of(Light& light) {
  ChangeableFields fields;
  const auto stands = [&](PointLight& point) {
    fields.position_mm = &point.position_mm;
    fields.irradiance = &point.irradiance;
  };
  if (auto* point = std::get_if<PointLight>(&light)) stands(*point);
  if (auto* spot = std::get_if<SpotLight>(&light)) stands(spot->point);
  if (auto* projector = std::get_if<ProjectorLight>(&light)) stands(projector->point);
  if (auto* directional = std::get_if<DirectionalLight>(&light)) {
    fields.direction = &directional->direction;
    fields.irradiance = &directional->irradiance;
  }
  if (auto* environment = std::get_if<EnvironmentLight>(&light)) {
    fields.turn_deg = &environment->turn_deg;
    fields.radiance = &environment->radiance;
  }
  return fields;
}

bool equal(const DirectionalLight& a, const DirectionalLight& b) {
  return a.direction == b.direction && (a.irradiance == b.irradiance).all();
}

bool equal(const PointLight& a, const PointLight& b) {
  return a.position_mm == b.position_mm && (a.irradiance == b.irradiance).all() &&
         a.at_mm == b.at_mm;
}

bool equal(const SpotLight& a, const SpotLight& b) {
  return equal(a.point, b.point) && a.target_mm == b.target_mm && a.cone_deg == b.cone_deg &&
         a.edge_deg == b.edge_deg;
}

bool equal(const ProjectorLight& a, const ProjectorLight& b) {
  return equal(a.point, b.point) && a.target_mm == b.target_mm && a.up == b.up &&
         a.fov_deg == b.fov_deg && a.image == b.image;
}

bool equal(const EnvironmentLight& a, const EnvironmentLight& b) {
  return a.image == b.image && (a.radiance == b.radiance).all() && a.turn_deg == b.turn_deg &&
         a.visible == b.visible;
}

}  // namespace

bool same(const Light& a, const Light& b) {
  return std::visit(
      [](const auto& one, const auto& other) {
        if constexpr (std::is_same_v<decltype(one), decltype(other)>) return equal(one, other);
        return false;
      },
      a, b);
}

LightChanges light_changes(const std::vector<Light>& before, const std::vector<Light>& after) {
  check(before.size() == after.size(), "lights that change are as many as before");
  LightChanges changes;
  for (std::size_t i = 0; i < before.size(); ++i) {
    Light one = before[i], other = after[i];
    const ChangeableFields was = fields_of(one), is = fields_of(other);
    LightChange change;
    change.light = i;
    const auto note = [](const auto* old, const auto* now, auto& to) {
      if (now == nullptr) return;
      using Value = typename std::decay_t<decltype(to)>::value_type;
      const Value was_value(*old), value(*now);
      if (was_value != value) to = value;
    };
    note(was.position_mm, is.position_mm, change.position_mm);
    note(was.direction, is.direction, change.direction);
    note(was.turn_deg, is.turn_deg, change.turn_deg);
    note(was.irradiance, is.irradiance, change.irradiance);
    note(was.radiance, is.radiance, change.radiance);
    if (!change.empty()) changes.push_back(change);
  }
  return changes;
}

void change_lights(const LightChanges& changes, const std::string& origin,
                   std::vector<Light>& lights) {
  for (const LightChange& change : changes) {
    const std::string name = origin + ": light " + std::to_string(change.light + 1);
    if (change.light >= lights.size()) {
      throw InputError(name + " is not there: the scene has " + std::to_string(lights.size()) +
                       "; take it out of 'lights'");
    }
    const ChangeableFields fields = fields_of(lights[change.light]);
    const auto set = [&](const auto& value, auto* to, const char* field) {
      if (!value) return;
      if (to == nullptr) {
        throw InputError(name + " is of a kind that has no '" + field +
                         "'; take that out of 'lights'");
      }
      *to = *value;
    };
    set(change.position_mm, fields.position_mm, "position_mm");
    set(change.direction, fields.direction, "direction");
    set(change.turn_deg, fields.turn_deg, "turn_deg");
    set(change.irradiance, fields.irradiance, "irradiance");
    set(change.radiance, fields.radiance, "radiance");
  }
}

void expect_agreement(const LightChanges& changes, const std::string& origin,
                      const LightChanges& others, const std::string& other_origin) {
  for (const LightChange& change : changes) {
    for (const LightChange& other : others) {
      if (other.light != change.light) continue;
      const auto expect_same = [&](const auto& value, const auto& otherwise, const char* field) {
        if (!value || !otherwise || *value == *otherwise) return;
        throw InputError(origin + ": light " + std::to_string(change.light + 1) + ": '" + field +
                         "' is another one in " + other_origin +
                         "; write one value, or take it out of 'lights' of one of the two");
      };
      expect_same(change.position_mm, other.position_mm, "position_mm");
      expect_same(change.direction, other.direction, "direction");
      expect_same(change.turn_deg, other.turn_deg, "turn_deg");
      expect_same(change.irradiance, other.irradiance, "irradiance");
      expect_same(change.radiance, other.radiance, "radiance");
    }
  }
}

}  // namespace kappamu::render
