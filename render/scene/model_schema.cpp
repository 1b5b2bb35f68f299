#include "render/scene/model_schema.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "forward/registry.h"

namespace kappamu::render {

namespace {

using Json = nlohmann::ordered_json;

Json schema_of(const Option& option, OptionReference reference) {
  Json schema{{"description", option.text}};
  const OptionValue usual = value_of(reference);
  if (std::holds_alternative<bool>(usual)) schema["type"] = "boolean";
  if (std::holds_alternative<std::string>(usual)) schema["type"] = "string";
  if (std::holds_alternative<double>(usual)) {
    schema["type"] = std::holds_alternative<double*>(reference) ? "number" : "integer";
    const Bounds& bounds = option.bounds;
    if (std::isfinite(bounds.least))
      schema[bounds.closed ? "minimum" : "exclusiveMinimum"] = bounds.least;
    if (std::isfinite(bounds.most)) schema["exclusiveMaximum"] = bounds.most;
  }
  std::visit([&](const auto& value) { schema["default"] = value; }, usual);
  return schema;
}

}  // namespace

std::string model_schema() {
  Json models = Json::array();
  for (const forward::ModelDescription& model : forward::object_models()) {
    Json properties{{"_comment", true},
                    {"name", {{"const", model.name}}},
                    {"tolerance", {{"$ref", "#/$defs/tolerance"}}},
                    {"max_elements", {{"$ref", "#/$defs/max_elements"}}},
                    {"follow_reentry", {{"$ref", "#/$defs/follow_reentry"}}}};
    model.make()->describe([&](const Option& option, OptionReference reference) {
      properties[option.name] = schema_of(option, reference);
    });
    models.push_back({{"description", model.text + " " + model.limits},
                      {"type", "object"},
                      {"additionalProperties", false},
                      {"required", {"name"}},
                      {"properties", std::move(properties)}});
  }
  return Json{{"oneOf", std::move(models)}}.dump(2) + "\n";
}

}  // namespace kappamu::render
