// What models of objects were measured to err and to cost against transport, as laws in a few
// features of the object. The numbers are in measured_models.inc, written by scripts/fit_choice.py
// from the record of `kappamu bench objects` on its tuning scenes; docs/objects-bench.md.
#pragma once

#include <span>
#include <string_view>

#include "forward/choice/object_features.h"

namespace kappamu::forward {

/// log(value) = constant + the sum of slopes times logarithms, natural ones.
struct Law {
  double constant = 0.0;
  double thickness = 0.0;   ///< slope in log(thickness)
  double absorption = 0.0;  ///< in log(1 − albedo)
  double edges = 0.0;       ///< in log(edges + 0.003)
  double contrast = 0.0;    ///< in log(contrast)
  double triangles = 0.0;   ///< in log(triangles)
  double tolerance = 0.0;   ///< in log(tolerance) that the model is asked for
  double spread = 0.0;      ///< standard deviation of log(value) about the law, dimensionless
};

struct MeasuredModel {
  std::string_view name;    ///< as make_object_model() knows it
  bool any_medium = false;  ///< takes κ and μ that vary
  bool any_shape = false;   ///< else only boxes of whole voxels
  bool reentry = false;     ///< follows light that meets the object again
  /// Relative error in the 2-norm, of physics: the model's numerics were 1 % or better.
  /// `montecarlo`: the noise of the triangles, times the square root of the photons.
  Law error;
  Law seconds;  ///< of processor, of one channel and light; `montecarlo`: per photon
  /// That the probe of forward/choice/machine_costs.h took on the table's machine [s].
  double probe_seconds = 0.0;
};

/// Of the scenes measured; beyond, errors are not known.
struct MeasuredRange {
  double thinnest = 0.0, thickest = 0.0;  ///< thickness
  double lowest_albedo = 0.0, highest_albedo = 1.0;
  double highest_contrast = 1.0;
};

std::span<const MeasuredModel> measured_models();
MeasuredRange measured_range();

/// Features beyond the measured range count as its end.
double value_of(const Law& law, const ObjectFeatures& features, double tolerance);

}  // namespace kappamu::forward
