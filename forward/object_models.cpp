#include "forward/object_models.h"

#include <array>
#include <string_view>

#include "core/error.h"
#include "forward/block/block_model.h"
#include "forward/boundary_integral/boundary_integral_model.h"
#include "forward/dipole/dipole_model.h"
#include "forward/embedded/embedded_model.h"
#include "forward/montecarlo/object_monte_carlo.h"
#include "forward/polygrid/polygrid_model.h"

namespace kappamu::forward {

namespace {

using Made = std::unique_ptr<ObjectModel>;

struct NamedModel {
  const char* name;
  Made (*make)(std::string_view name);
  /// Whose law of errors it has; none: it is right wherever it is given time.
  const char* errs_as = nullptr;
};

template <class Model>
Made plain(std::string_view) {
  return std::make_unique<Model>();
}

constexpr std::array<NamedModel, 10> models{{
    {"embedded", plain<EmbeddedModel>, "embedded"},
    {"grid", plain<BlockModel>, "grid"},
    {"polygrid", plain<PolygridModel>, "embedded"},
    {"boundary_integral", plain<BoundaryIntegralModel>, "embedded"},
    {"montecarlo", [](std::string_view) { return make_object_monte_carlo(); }},
    {"dipole", make_dipole_model, "dipole-rotated"},
    {"dipole-rotated", make_dipole_model, "dipole-rotated"},
    {"local-diffusion", make_dipole_model, "dipole-rotated"},
    {"better-dipole", make_dipole_model, "better-dipole"},
    {"beam-diffusion", make_dipole_model, "better-dipole"},
}};

}  // namespace

Made make_object_model(const std::string& name, ModelError error) {
  std::string known;
  for (const NamedModel& model : models) {
    if (name == model.name) {
      if (!model.errs_as || error == ModelError::left_out) return model.make(name);
      return with_model_error(model.make(name), model.errs_as, error == ModelError::warned);
    }
    known += (known.empty() ? "" : ", ") + std::string(model.name);
  }
  throw InputError("there is no model '" + name + "' of objects; the models are " + known);
}

}  // namespace kappamu::forward
