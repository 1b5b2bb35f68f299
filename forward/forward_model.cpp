#include "forward/forward_model.h"

#include "core/error.h"
#include "forward/analytic/layered_block.h"
#include "forward/choice/auto_block.h"
#include "forward/grid/grid_model.h"
#include "forward/montecarlo/monte_carlo_model.h"

namespace kappamu::forward {

namespace {

struct Entry {
  MethodName name;
  std::unique_ptr<ForwardModel> (*make)();
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all{
      {{"multigrid", "grid diffusion by multigrid-preconditioned conjugate gradients"},
       make_multigrid_model},
      {{"reference", "grid diffusion in plain serial double precision, for checking"},
       make_reference_model},
      {{"analytic", "diffusion in closed form, for layered blocks with mirror sides"},
       make_analytic_model},
      {{.name = "montecarlo",
        .description = "radiative transfer by Monte Carlo, with standard errors (OpenCL only)",
        .transport = true},
       make_monte_carlo_model},
      {{.name = "auto",
        .description = "multigrid or montecarlo: the cheaper of those measured to be within "
                       "--model-tolerance",
        .transport = true},
       make_auto_block_model},
  };
  return all;
}

}  // namespace

const std::vector<MethodName>& forward_methods() {
  static const std::vector<MethodName> names = [] {
    std::vector<MethodName> list;
    for (const Entry& entry : entries()) list.push_back(entry.name);
    return list;
  }();
  return names;
}

std::unique_ptr<ForwardModel> make_forward_model(const std::string& method) {
  std::string known;
  for (const Entry& entry : entries()) {
    if (entry.name.name == method) return entry.make();
    known += (known.empty() ? "'" : ", '") + entry.name.name + "'";
  }
  throw InputError("--method '" + method + "' is unknown; choose one of " + known + ".");
}

}  // namespace kappamu::forward
