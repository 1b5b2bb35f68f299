#include "forward/grid/solve_verdict.h"

#include <cmath>
#include <sstream>

#include "forward/rounding_floor.h"

namespace kappamu::forward {

void conclude(SolveReport& report, double tolerance, bool stagnated, Precision precision) {
  double worst = 0.0;
  for (const double residual : report.residual) {
    if (!(residual <= worst)) worst = residual;  // NaN stays
    if (!std::isfinite(worst)) break;
  }
  std::ostringstream message;
  message << "relative residual " << worst << " after " << report.iterations << " iterations";
  if (!std::isfinite(worst)) {
    report.termination = Termination::failed;
    message << ", not a number: the right-hand side or the start is not finite";
  } else if (worst <= tolerance) {
    report.termination = Termination::converged;
  } else {
    report.termination = Termination::ran_out;
    message << ", tolerance " << tolerance << " not met";
    if (stagnated) message << ": " << rounding_floor_sentence(precision);
  }
  report.message = message.str();
}

}  // namespace kappamu::forward
