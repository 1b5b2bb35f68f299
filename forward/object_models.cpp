#include "forward/object_models.h"

#include <array>
#include <string_view>

#include "core/error.h"
#include "forward/block/block_model.h"
#include "forward/boundary_integral/boundary_integral_model.h"
#include "forward/dipole/dipole_model.h"
#include "forward/embedded/embedded_model.h"
#include "forward/montecarlo/object_monte_carlo.h"
#include "forward/object_validity.h"
#include "forward/polygrid/polygrid_model.h"

namespace kappamu::forward {

namespace {

using Made = std::unique_ptr<ObjectModel>;

struct NamedModel {
  const char* name;
  Made (*make)(std::string_view name);
  bool of_diffusion = false;  ///< grids and integrals, which do not see where it errs
};

template <class Model>
Made plain(std::string_view) {
  return std::make_unique<Model>();
}

constexpr std::array<NamedModel, 10> models{{
    {"embedded", plain<EmbeddedModel>, true},
    {"grid", plain<BlockModel>, true},
    {"polygrid", plain<PolygridModel>, true},
    {"boundary_integral", plain<BoundaryIntegralModel>, true},
    {"montecarlo", [](std::string_view) { return make_object_monte_carlo(); }},
    {"dipole", make_dipole_model},
    {"dipole-rotated", make_dipole_model},
    {"local-diffusion", make_dipole_model},
    {"better-dipole", make_dipole_model},
    {"beam-diffusion", make_dipole_model},
}};

}  // namespace

Made make_object_model(const std::string& name, DiffusionWarning warning) {
  std::string known;
  for (const NamedModel& model : models) {
    if (name == model.name) {
      const bool warns = model.of_diffusion && warning == DiffusionWarning::given;
      return warns ? warned_of_diffusion(model.make(name)) : model.make(name);
    }
    known += (known.empty() ? "" : ", ") + std::string(model.name);
  }
  throw InputError("there is no model '" + name + "' of objects; the models are " + known);
}

}  // namespace kappamu::forward
