// A short random walk on the very object, which settles whether a model is within the tolerance
// where its law leaves that open.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "forward/choice/choice.h"

namespace kappamu::forward {

/// What is known of a model's relative 2-norm error: a law with its spread, and a measurement.
struct ErrorBelief {
  double law = 0.0, spread = 0.0;               ///< median, and standard deviation of its logarithm
  double square = 0.0, square_deviation = 0.0;  ///< of the error's square, measured; it may be < 0
};

/// Probability that the error is at most `bound`, by Bayes' rule; by the law alone where
/// `square_deviation` is 0.
double probability_below(const ErrorBelief& belief, double bound);

struct Pilot {
  std::string model;
  ErrorBelief belief;        ///< of the channel and light least likely to be within the tolerance
  double probability = 0.0;  ///< that its error is within the tolerance
  bool within = false;
  std::uint64_t photons = 0;
  std::vector<ObjectResult> results;  ///< of the model

  /// Measured; 0 where noise hides it.
  double error() const { return std::sqrt(std::max(0.0, belief.square)); }
};

/// Where a cheaper model than the one taken may be within the tolerance, or the law of the one
/// taken leaves a doubt: solves by that model, walks until the pilot's noise decides, and puts the
/// model first if it is within, behind the others if it was taken and is not. The candidates'
/// reasons state what was measured. The last pilot; none where no model is in question.
std::optional<Pilot> run_pilot(std::span<const ObjectProblem> problems,
                               std::span<const ObjectFeatures> channels, const ObjectOptions& asked,
                               const MachineCosts& costs, Choice& choice, Progress& progress);

}  // namespace kappamu::forward
