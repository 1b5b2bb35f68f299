// What is known of a model's error on one object: the law of the table, and what short walks
// measured.
#pragma once

namespace kappamu::forward {

/// Of a relative 2-norm error.
struct ErrorBelief {
  double law = 0.0, spread = 0.0;               ///< median, and standard deviation of its logarithm
  double square = 0.0, square_deviation = 0.0;  ///< of the error's square, measured; it may be < 0
};

/// What the error does not exceed with this probability, by Bayes' rule; by the law alone where
/// `square_deviation` is 0.
double error_quantile(const ErrorBelief& belief, double probability);

}  // namespace kappamu::forward
