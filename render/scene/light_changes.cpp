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

/// Calls visit(field of a change, field of a light, name) for all of them.
template <class Visit>
void for_fields(const Visit& visit) {
  visit(&LightChange::position_mm, &ChangeableFields::position_mm, "position_mm");
  visit(&LightChange::direction, &ChangeableFields::direction, "direction");
  visit(&LightChange::turn_deg, &ChangeableFields::turn_deg, "turn_deg");
  visit(&LightChange::irradiance, &ChangeableFields::irradiance, "irradiance");
  visit(&LightChange::radiance, &ChangeableFields::radiance, "radiance");
}

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
    for_fields([&](auto of_change, auto of_light, const char* /*name*/) {
      if (is.*of_light == nullptr) return;
      using Value = typename std::decay_t<decltype(change.*of_change)>::value_type;
      const Value was_value(*(was.*of_light)), value(*(is.*of_light));
      if (was_value != value) change.*of_change = value;
    });
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
    for_fields([&](auto of_change, auto of_light, const char* field) {
      if (!(change.*of_change)) return;
      if (fields.*of_light == nullptr) {
        throw InputError(name + " is of a kind that has no '" + field +
                         "'; take that out of 'lights'");
      }
      *(fields.*of_light) = *(change.*of_change);
    });
  }
}

void expect_agreement(const LightChanges& changes, const std::string& origin,
                      const LightChanges& others, const std::string& other_origin) {
  for (const LightChange& change : changes) {
    for (const LightChange& other : others) {
      if (other.light != change.light) continue;
      for_fields([&](auto of_change, auto /*of_light*/, const char* field) {
        const auto &value = change.*of_change, &otherwise = other.*of_change;
        if (!value || !otherwise || *value == *otherwise) return;
        throw InputError(origin + ": light " + std::to_string(change.light + 1) + ": '" + field +
                         "' is another one in " + other_origin +
                         "; write one value, or take it out of 'lights' of one of the two");
      });
    }
  }
}

}  // namespace kappamu::render
