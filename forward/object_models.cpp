#include "forward/object_models.h"

#include "core/error.h"
#include "forward/embedded/embedded_model.h"

namespace kappamu::forward {

std::unique_ptr<ObjectModel> make_object_model(const std::string& name) {
  if (name == "embedded") return std::make_unique<EmbeddedModel>();
  throw InputError("there is no model '" + name + "' of objects; write embedded");
}

}  // namespace kappamu::forward
