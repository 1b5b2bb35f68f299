#include "forward/object_verdict.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/surface_norm.h"
#include "core/shown_text.h"

namespace kappamu::forward {

void conclude(const Surface& surface, const Ended& ended, const std::string& elements,
              ObjectResult& result) {
  double worst = 0.0;
  for (std::size_t l = 0; l < result.error_estimate.size(); ++l) {
    const auto first = result.exitance.begin() + static_cast<std::ptrdiff_t>(l * surface.size());
    const double size = surface_norm(
        surface, std::vector<double>(first, first + static_cast<std::ptrdiff_t>(surface.size())));
    double& error = result.error_estimate[l];
    error = size > 0.0 ? std::sqrt(error) / size : 0.0;
    worst = std::max(worst, error);
  }
  result.converged = ended.within_tolerance && ended.solved;
  if (!ended.solved) {
    result.message = "the linear solver stopped before its tolerance";
  } else if (!ended.within_tolerance) {
    result.message = formatted("stopped at %zu %s, the most allowed, with an estimated error of %g",
                               result.elements, elements.c_str(), worst);
  } else {
    result.message = formatted("the estimated error %g is within the tolerance", worst);
  }
  if (!result.converged) result.warnings.push_back(result.message);
}

}  // namespace kappamu::forward
