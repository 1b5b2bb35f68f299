// SharedErrors as text.
#include <cmath>

#include "core/shown_text.h"
#include "inverse/data_checks/shared_errors.h"

namespace kappamu::inverse {

double SharedErrors::mean_off() const {
  return stated > 0.0 ? std::abs(mean) / stated : 0.0;
}

std::string mean_in_words(const SharedErrors& errors) {
  return formatted("predicted %.2g %% too %s in the mean", 100.0 * std::abs(errors.mean),
                   errors.mean < 0.0 ? "dark" : "bright");
}

std::string octave_in_words(const SharedErrors& errors) {
  const OctaveMisfit& octave = errors.octave;
  const char* whose = octave.of_mean ? "all patterns" : "single patterns";
  const double times = std::sqrt(octave.chi2 / octave.values);
  if (octave.longest == 0.0) {
    return formatted("the mean light of %s is %.2g times its stated error off", whose, times);
  }
  return formatted("waves of %.3g to %.3g voxels of %s are %.2g times their stated errors off",
                   0.5 * octave.longest, octave.longest, whose, times);
}

}  // namespace kappamu::inverse
