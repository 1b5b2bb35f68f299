#include "forward/grid/solve_verdict.h"

#include <cmath>

#include "core/shown_text.h"
#include "forward/grid/rounding_floor.h"

namespace kappamu::forward {

void conclude(SolveReport& report, double tolerance, bool stagnated, Precision precision) {
  double worst = 0.0;
  for (const double residual : report.residual) {
    if (!(residual <= worst)) worst = residual;  // NaN stays
    if (!std::isfinite(worst)) break;
  }
  report.message = formatted("relative residual %g after %d iterations", worst, report.iterations);
  if (!std::isfinite(worst)) {
    report.termination = Termination::failed;
    report.message += ", not a number: the right-hand side or the start is not finite";
  } else if (worst <= tolerance) {
    report.termination = Termination::converged;
  } else {
    report.termination = Termination::ran_out;
    report.message += formatted(", tolerance %g not met", tolerance);
    if (stagnated) report.message += ": " + rounding_floor_sentence(precision);
  }
}

}  // namespace kappamu::forward
