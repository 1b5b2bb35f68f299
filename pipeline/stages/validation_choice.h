// Which of the measured patterns a fit keeps out to be validated by: `--hold-out`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/surface_measurements.h"

namespace kappamu::pipeline {

/// What a fit is validated by.
struct ValidationChoice {
  enum class Source {
    none,          ///< nothing
    fitted_input,  ///< patterns taken from the measurements to fit
    validation     ///< measurements of their own
  };
  Source source = Source::none;
  std::vector<int> patterns;           ///< kept out of the measurements to fit, rising
  std::optional<std::string> warning;  ///< why nothing is kept out although nobody said so
};
std::string to_string(ValidationChoice::Source source);

/// Whether the input has measurements of validation patterns beside those to fit.
enum class ValidationMeasurements { absent, present };

/// `choice` is "auto", "none", a count, or pattern numbers (from 0) with commas ("5,10"; "5," is
/// pattern 5 alone). With validation measurements "auto" keeps nothing of the others out. Throws
/// InputError naming the option.
ValidationChoice choose_validation(const std::string& choice,
                                   const SurfaceMeasurements& measurements,
                                   ValidationMeasurements validation);

}  // namespace kappamu::pipeline
