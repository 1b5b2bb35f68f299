// The sections of the report, one file each, in the order of the page.
#pragma once

#include <string>
#include <vector>

#include "report/drawing/html.h"
#include "report/read/run_data.h"

namespace kappamu::report {

Html verdict_section(const RunData& run);
Html capture_section(const RunData& run);
Html calibration_section(const RunData& run);
Html radiometry_section(const RunData& run);
Html convergence_section(const RunData& run);
Html volumes_section(const RunData& run);
Html uncertainty_section(const RunData& run);
Html comparison_section(const RunData& run);
Html provenance_section(const RunData& run);

/// Every warning of every stage, each once.
std::vector<std::string> all_warnings(const RunData& run);

}  // namespace kappamu::report
