#include "report/drawing/slices.h"
#include "report/sections.h"

namespace kappamu::report {

Html volumes_section(const RunData& run) {
  if (!run.fit || run.fit->media.empty())
    return section("Volumes", note("This run has no fitted volumes yet."));
  Html content = slice_slider();
  for (std::size_t c = 0; c < run.fit->media.size(); ++c) {
    const Medium& medium = run.fit->media[c];
    content += subsection("κ, diffusion coefficient, channel " + run.fit->channels[c],
                          slices(medium.kappa, "κ", "mm"));
    content += subsection("μ, absorption coefficient, channel " + run.fit->channels[c],
                          slices(medium.mu, "μ", "1/mm"));
  }
  if (run.fit->means_of > 1) {
    const std::string edge = std::to_string(run.fit->means_of);
    content += note("The volumes are too large for this page: shown are means over " + edge +
                    " voxels along each axis, and below the middle layer as fitted.");
    const std::string where = "z = " + number(run.fit->middle_mm) + " mm";
    for (std::size_t c = 0; c < run.fit->middle_layers.size(); ++c) {
      const auto& [kappa, mu] = run.fit->middle_layers[c];
      content += subsection("Middle layer, channel " + run.fit->channels[c],
                            layer(kappa, "κ", "mm", where) + layer(mu, "μ", "1/mm", where));
    }
  }
  content += note(
      "Light enters at z = 0; y points down. Each volume has its own "
      "scale, from the 0.5 % to the 99.5 % quantile. Continuous light does not determine κ and μ "
      "uniquely, least of all far from the surfaces: appearance under light that the "
      "fit did not see is what E compares.");
  return section("Volumes", content);
}

}  // namespace kappamu::report
