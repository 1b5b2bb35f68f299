// Apart from the models, so that who reads scenes need not link them.
#include "forward/object_models.h"

namespace kappamu::forward {

std::vector<std::string> object_model_names() {
  return {"embedded", "grid",           "polygrid",        "boundary_integral", "montecarlo",
          "dipole",   "dipole-rotated", "local-diffusion", "better-dipole",     "beam-diffusion"};
}

}  // namespace kappamu::forward
