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
      {{.name = "multigrid",
        .description = "grid diffusion by multigrid-preconditioned conjugate gradients",
        .any_light = true},
       make_multigrid_model},
      {{.name = "reference",
        .description = "grid diffusion in plain serial double precision, for checking",
        .any_light = true},
       make_reference_model},
      {{"analytic", "diffusion in closed form, for layered blocks with mirror sides"},
       make_analytic_model},
      {{.name = "montecarlo",
        .description = "radiative transfer by Monte Carlo, with standard errors (OpenCL only)",
        .transport = true,
        .any_light = true},
       make_monte_carlo_model},
      {{.name = "auto",
        .description = "multigrid or montecarlo: the cheaper of those measured to be within "
                       "the tolerance asked of the model",
        .transport = true},
       make_auto_block_model},
  };
  return all;
}

/// Refuses what the model within would leave out without a word.
class PlainLightOnly final : public ForwardModel {
 public:
  explicit PlainLightOnly(const Entry& entry) : name_(entry.name.name), model_(entry.make()) {}

  ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& options,
                      Progress& progress) const override {
    const auto refuse = [&](const char* what) {
      throw InputError("method '" + name_ + "' " + what +
                       "; choose multigrid, reference or montecarlo");
    };
    if (!problem.light.plain()) refuse("takes neither oblique light nor points");
    if (options.fluence) refuse("does not give the fluence");
    return model_->solve(problem, options, progress);
  }

 private:
  std::string name_;
  std::unique_ptr<ForwardModel> model_;
};

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
    if (entry.name.name == method) {
      if (entry.name.any_light) return entry.make();
      return std::make_unique<PlainLightOnly>(entry);
    }
    known += (known.empty() ? "'" : ", '") + entry.name.name + "'";
  }
  throw InputError("there is no method '" + method + "'; choose one of " + known, {{"method"}});
}

}  // namespace kappamu::forward
