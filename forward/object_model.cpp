#include "forward/object_model.h"

#include "core/error.h"
#include "forward/live_model.h"

namespace kappamu::forward {

void ObjectModel::set(const OptionValues& parameters) {
  std::string known;
  std::size_t taken = 0;
  describe([&](const Option& option, OptionReference reference) {
    known += (known.empty() ? "" : ", ") + std::string(option.name);
    const auto given = parameters.find(option.name);
    if (given == parameters.end()) return;
    set_option(option, reference, given->second);
    ++taken;
  });
  if (taken == parameters.size()) return;
  const OptionValues own = this->parameters();
  for (const auto& [name, value] : parameters) {
    if (own.contains(name)) continue;
    throw InputError("the model has no parameter '" + name + "'; " +
                     (known.empty() ? "it has none of its own" : "its own are " + known));
  }
}

OptionValues ObjectModel::parameters() {
  OptionValues values;
  describe([&](const Option& option, OptionReference reference) {
    values[option.name] = value_of(reference);
  });
  return values;
}

std::unique_ptr<LiveModel> ObjectModel::keep(const LiveBody& /*object*/,
                                             const ObjectOptions& /*options*/,
                                             Progress& /*progress*/) {
  return nullptr;
}

}  // namespace kappamu::forward
