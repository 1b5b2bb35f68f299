#include "forward/object_models.h"

#include "core/error.h"
#include "forward/embedded/embedded_model.h"
#include "forward/montecarlo/object_monte_carlo.h"

namespace kappamu::forward {

std::unique_ptr<ObjectModel> make_object_model(const std::string& name) {
  if (name == "embedded") return std::make_unique<EmbeddedModel>();
  if (name == "montecarlo") return make_object_monte_carlo();
  throw InputError("there is no model '" + name + "' of objects; write embedded or montecarlo");
}

}  // namespace kappamu::forward
