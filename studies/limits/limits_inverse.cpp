// Where the inverse solve meets its limits, what comes out there and what the program reports.

#include "studies/limits/limits.h"
#include "tests/cases/limit_inverse.h"

namespace kappamu::studies {

using namespace test_cases;

Json limit_inverse(const Request& request, Progress& progress) {
  Json rows = Json::array();
  for (const InverseLimit& limit : inverse_limits()) {
    progress.update("inverse", 0.0, limit.name);
    const InverseLimitOutcome outcome = run_inverse_limit(limit, request.device);
    Json row{{"case", limit.name}};
    if (outcome.fit) {
      const inverse::FitReport& report = outcome.fit->report;
      row["model"] = to_string(report.model.model);
      row["ended"] = inverse::to_string(report.status);
      row["χ² per value"] = report.chi2_per_value;
      row["E, light not fitted"] = outcome.error;
      row["κ error"] = outcome.kappa_error;
      row["μ error"] = outcome.mu_error;
    }
    row["warnings"] = outcome.warnings;
    row["notes"] = outcome.notes;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace kappamu::studies
