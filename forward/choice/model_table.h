// What models of objects were measured to err and to cost against transport, as laws in a few
// features of the object. The numbers are in measured_models.inc, written by studies/fit_choice.py
// from the record of `kappamu-studies objects` on its tuning scenes; docs/objects-bench.md.
#pragma once

#include <span>
#include <string_view>

#include "forward/choice/object_features.h"

namespace kappamu::forward {

/// Error: a sum of terms, each a coefficient, not negative, times what its name says; each times
/// e^(diffuse · share of diffuse light + slant · what that of beams exceeds a sphere's, by their
/// share), `absorbed` with its own slope for diffuse light, under which it grows with the power 3/2
/// of 1 − albedo.
struct ErrorLaw {
  double constant = 0.0;
  double inverse_thickness = 0.0, inverse_root_thickness = 0.0;
  /// 1 − albedo times t/(t + 3), t the thickness: light that leaves a thin object sooner is
  /// absorbed less often; and the root of 1 − albedo.
  double absorbed = 0.0, root_absorbed = 0.0;
  double edges = 0.0;
  double inverse_size = 0.0;
  double diffuse = 0.0, slant = 0.0, absorbed_diffuse = 0.0;
  /// Standard deviation of log(error measured / law) on shapes that the law was not fitted to, of
  /// errors above it.
  double spread = 0.0;
};

/// Seconds: log(value) = constant + slopes times natural logarithms of what their names say.
struct CostLaw {
  double constant = 0.0;
  double thickness = 0.0, absorbed = 0.0, contrast = 0.0, triangles = 0.0;
  double tolerance = 0.0;  ///< that the model is asked for
};

struct MeasuredModel {
  std::string_view name;  ///< in the registry
  /// Relative error in the 2-norm, of physics: the model's numerics were 1 % or better.
  /// `montecarlo`: the noise of patches, times the root of photons over their number.
  ErrorLaw error;
  CostLaw seconds;  ///< of processor, of one channel and light; `montecarlo`: per photon
  /// Of processor, that the probe of forward/choice/machine_costs.h took on the table's machine.
  double probe_seconds = 0.0;
};

/// Of the scenes measured; beyond, errors are not known.
struct MeasuredRange {
  double thinnest = 0.0, thickest = 0.0;  ///< thickness
  double lowest_albedo = 0.0, highest_albedo = 1.0;
  double highest_contrast = 1.0;
  double most_slant = 1.0;
};

/// The one of that name, which is there.
const MeasuredModel& measured(std::string_view name);
MeasuredRange measured_range();

/// Features beyond the measured range count as its end, but for the thickness of thinner objects
/// and lower albedos in errors: random walks' noise grows on.
double error_by(const ErrorLaw& law, const ObjectFeatures& features);
double seconds_by(const CostLaw& law, const ObjectFeatures& features, double tolerance);

}  // namespace kappamu::forward
