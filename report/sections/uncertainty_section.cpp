#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "report/drawing/picture.h"
#include "report/drawing/slices.h"
#include "report/sections.h"

namespace kappamu::report {

namespace {

Html deviation_slices(const Volume<double>& deviation, const std::string& symbol) {
  const std::vector<float> values(deviation.values().begin(), deviation.values().end());
  return slices(deviation, "σ of log " + symbol, "",
                std::pair{0.0, std::max(quantile(values, 0.995), 1e-6)});
}

Html resolution_slices(const Volume<double>& resolution, const std::string& symbol) {
  return slices(resolution, "resolution of " + symbol, "", std::pair{0.0, 1.0});
}

}  // namespace

Html uncertainty_section(const RunData& run) {
  const auto stated = [](const auto& found) { return found.has_value(); };
  if (!run.fit || std::none_of(run.fit->uncertainty.begin(), run.fit->uncertainty.end(), stated)) {
    return section("Uncertainty", note("This fit states no uncertainty of its volumes."));
  }
  Html content;
  for (std::size_t c = 0; c < run.fit->uncertainty.size(); ++c) {
    if (!run.fit->uncertainty[c]) continue;
    const FitUncertainty& found = *run.fit->uncertainty[c];
    content += subsection("Channel " + run.fit->channels[c],
                          paragraph(found.sentence) + deviation_slices(found.deviation.kappa, "κ") +
                              resolution_slices(found.resolution.kappa, "κ") +
                              deviation_slices(found.deviation.mu, "μ") +
                              resolution_slices(found.resolution.mu, "μ"));
  }
  content += note(
      "σ of log κ = 0.1 says that κ is known to about 10 %, 0.7 within a factor of 2. It includes "
      "what fits of such contrast miss of known truths; scale, pose and voxels that are too wide "
      "are not in it. Resolution is the share of a voxel's variance that the data removed from "
      "what the smoothing alone allows: near 1 the data decide the value, near 0 the smoothing "
      "does, whatever the picture above shows.");
  return section("Uncertainty", content);
}

}  // namespace kappamu::report
