// The sections of the report, one file each, in the order of the page.
#pragma once

#include <string>
#include <vector>

#include "report/drawing/html.h"
#include "report/read/run_data.h"

namespace kappamu::report {

enum class Light { green, amber, red, grey };

/// One statement of the verdict: how good, and the sentence that says why.
struct Criterion {
  Light light = Light::grey;  ///< grey: the run does not say
  std::string name;
  std::string sentence;
};

/// Judges calibration, exposure, fit, prediction of held-out patterns and warnings, by the bounds
/// that verdict.cpp names.
std::vector<Criterion> judge(const RunData& run);
/// The worst light that is not grey; grey when there is none.
Light overall(const std::vector<Criterion>& criteria);

Html verdict_section(const std::vector<Criterion>& criteria);
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
