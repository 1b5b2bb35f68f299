#include "forward/registry.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "forward/block/block_model.h"
#include "forward/boundary_integral/boundary_integral_model.h"
#include "forward/choice/auto_model.h"
#include "forward/dipole/dipole_model.h"
#include "forward/embedded/embedded_model.h"
#include "forward/montecarlo/object_monte_carlo.h"
#include "forward/polygrid/polygrid_model.h"

namespace kappamu::forward {

namespace {

/// A new model of this tree is a line here.
std::deque<ModelDescription>& models() {
  static std::deque<ModelDescription> all{
      auto_model(),          embedded_model(),          block_model(),
      polygrid_model(),      boundary_integral_model(), monte_carlo_model(),
      dipole_model(),        rotated_dipole_model(),    local_diffusion_model(),
      better_dipole_model(), beam_diffusion_model(),
  };
  return all;
}

const ModelDescription* found(const std::string& name) {
  const auto model =
      std::ranges::find_if(models(), [&](const auto& one) { return one.name == name; });
  return model == models().end() ? nullptr : &*model;
}

}  // namespace

const std::deque<ModelDescription>& object_models() {
  return models();
}

void add_object_model(ModelDescription model) {
  if (found(model.name) != nullptr)
    throw InputError("there is a model '" + model.name + "' of objects; take another name");
  models().push_back(std::move(model));
}

const ModelDescription& object_model(const std::string& name) {
  if (const ModelDescription* model = found(name)) return *model;
  std::string known;
  for (const ModelDescription& model : models()) known += (known.empty() ? "" : ", ") + model.name;
  throw InputError("there is no model '" + name + "' of objects; the models are " + known);
}

const ModelDescription& transport_model() {
  return *std::ranges::find_if(models(), [](const auto& model) { return model.can.transport; });
}

std::vector<std::string> object_model_names() {
  std::vector<std::string> names;
  for (const ModelDescription& model : models()) {
    if (!model.can.chooses) names.push_back(model.name);
  }
  return names;
}

std::unique_ptr<ObjectModel> make_object_model(const std::string& name, ModelError error,
                                               const OptionValues& parameters) {
  const ModelDescription& description = object_model(name);
  std::unique_ptr<ObjectModel> model = description.make();
  model->set(parameters);
  if (error == ModelError::left_out || description.can.transport || description.can.chooses)
    return model;
  return with_model_error(std::move(model), description, error == ModelError::warned);
}

std::vector<std::string> names_of(const Abilities& abilities) {
  const std::pair<bool, const char*> all[] = {
      {abilities.any_shape, "any shape"}, {abilities.heterogeneous, "heterogeneous"},
      {abilities.voids, "voids"},         {abilities.several_bodies, "several bodies"},
      {abilities.reentry, "re-entry"},    {abilities.inner_light, "inner light"},
      {abilities.live, "live"},           {abilities.deforming, "deforming"},
  };
  std::vector<std::string> names;
  for (const auto& [can, name] : all) {
    if (can) names.emplace_back(name);
  }
  return names;
}

}  // namespace kappamu::forward
