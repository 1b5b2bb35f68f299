// Patterns kept out of the fit validate it: what a volume predicts under light that no voxel was
// fitted to, against what was measured there.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/appearance_error.h"
#include "core/grid.h"
#include "core/surface_measurements.h"
#include "inverse/problem/data_term.h"
#include "inverse/problem/predict.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

/// Number of `patterns` that a fit keeps out by default: one of every sixteen, at least one; none
/// of fewer than four, which a volume needs all (docs/theory.md, 4).
int usual_validation_count(int patterns);

/// Different lights among the patterns: fewer than patterns where some are seen on two faces.
int count_lights(const SurfaceMeasurements& measurements);

/// `count` of the measured patterns, in rising order: those whose light falls nearest the middle of
/// the lit face, far from each other. Light at the rim reaches voxels no other pattern does.
/// Of light that is seen on two faces, both pictures: there may be more than `count`.
/// Throws InputError unless 0 <= count < measurements.patterns.
std::vector<int> choose_validation_patterns(const SurfaceMeasurements& measurements, int count);

/// Those patterns alone, in the order given.
SurfaceMeasurements select_patterns(const SurfaceMeasurements& measurements,
                                    std::span<const int> patterns);
/// All others, in their order.
SurfaceMeasurements without_patterns(const SurfaceMeasurements& measurements,
                                     std::span<const int> patterns);

struct ValidationScore {
  AppearanceError error;                       ///< over what the mask allows
  std::vector<AppearanceError> pattern_error;  ///< [M], the same of each pattern
  double chi2_per_value = 0.0;                 ///< with the fit's variances, model error included
  std::vector<float> prediction;               ///< [M][v][u], the measured quantity
};

/// How `medium` predicts channel `channel` of `validation`, which must have passed validate().
ValidationScore validation_score(const Medium& medium, const SurfaceMeasurements& validation,
                                 int channel, const PredictOptions& options,
                                 const ModelError& model_error,
                                 const DataTermOptions& data_term = {});

}  // namespace kappamu::inverse
