#include "inverse/block_model/block_model.h"

#include <array>
#include <utility>

#include "core/error.h"

namespace kappamu::inverse {

namespace {

constexpr std::array<std::pair<Model, const char*>, 4> names{{{Model::automatic, "auto"},
                                                              {Model::homogeneous, "homogeneous"},
                                                              {Model::layered, "layered"},
                                                              {Model::volume, "volume"}}};

}  // namespace

std::string to_string(Model model) {
  for (const auto& [known, name] : names) {
    if (known == model) return name;
  }
  throw InternalError("to_string: unknown model");
}

Model model_of(const std::string& name) {
  for (const auto& [model, known] : names) {
    if (name == known) return model;
  }
  throw InputError("model '" + name + "' is unknown; choose auto, homogeneous, layered or volume");
}

}  // namespace kappamu::inverse
