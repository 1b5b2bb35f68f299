#include "lambert_model.h"

#include <cmath>

#include "core/optics.h"
#include "forward/dipole/transmitted.h"
#include "forward/light_entry.h"

namespace {

using namespace kappamu;
using namespace kappamu::forward;

/// Share of the entering light that leaves a half-space again (Jensen et al. 2001).
double half_space_reflectance(const Coefficients& medium, double eta) {
  const double albedo = 1.0 - 3.0 * medium.kappa * medium.mu;
  const double decay = std::sqrt(3.0 * (1.0 - albedo));
  return 0.5 * albedo * std::exp(-decay) *
         (1.0 + std::exp(-4.0 / 3.0 * boundary_constants(eta).A * decay));
}

class LambertModel final : public ObjectModel {
 public:
  void describe(const OptionVisitor& visit) override {
    visit({"reflectance", "Lambert", "", "", bounds::share,
           "Share of the entering light that leaves; 0 takes that of a half-space of the material"},
          &reflectance_);
  }

  ObjectResult solve(const ObjectProblem& problem, const ObjectOptions& options,
                     Progress& progress) override {
    check_problem(problem, options);
    const double share = reflectance_ > 0.0
                             ? reflectance_
                             : half_space_reflectance(problem.medium.smallest(), problem.eta);
    ObjectResult result;
    for (const ObjectLight& light : problem.lights) {
      ObjectBalance balance;
      const std::vector<double> entering = dipole::transmitted(problem.surface, problem.eta, light);
      for (std::size_t t = 0; t < entering.size(); ++t) {
        result.exitance.push_back(share * entering[t]);
        balance.entering += problem.surface.area[t] * entering[t];
      }
      balance.exiting = share * balance.entering;
      balance.absorbed = balance.entering - balance.exiting;
      result.balance.push_back(balance);
    }
    progress.update("lambert", 1.0, "");
    result.error_estimate.assign(problem.lights.size(), 0.0);  // of numerics; there are none
    result.elements = problem.surface.size();
    result.converged = true;
    result.message = "every triangle sends out a share of what enters it";
    return result;
  }

 private:
  double reflectance_ = 0.0;
};

}  // namespace

ModelDescription lambert_model() {
  return {.name = "lambert",
          .text = "Light leaves where it entered, as from a Lambertian surface.",
          .limits =
              "Nothing is translucent: only for homogeneous objects of many thousand mean "
              "free paths, and as a picture to compare others with.",
          .can = {.live = true},
          .make = [] { return std::make_unique<LambertModel>(); }};
}
