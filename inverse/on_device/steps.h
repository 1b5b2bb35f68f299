// The optimiser's steps along one FitFunction. On a GPU that the operator computes on, all vectors
// stay in its memory between them; elsewhere they are the host's.
#pragma once

#include <memory>

#include "inverse/optimise/fit_function.h"
#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse {

class Steps {
 public:
  /// From where `state` stands, after start() or a step. All must outlive this.
  Steps(Objective& objective, const Basis& basis, FitFunction& function, OptimiserState& state,
        const OptimiserOptions& options, VectorPlace place);
  ~Steps();

  bool on_device() const { return device_ != nullptr; }
  /// Of the state its value and products are set, and on the host all of it.
  StepOutcome step();
  /// Solves anew where the optimiser stands, which the next step needs.
  void solve();
  /// R where the optimiser stands.
  double roughness() const;
  /// The fields there, read from the device if they are its.
  CoefficientPair fields() const;
  /// The state becomes what it would be had the host stepped.
  void store() const;
  /// The same but for the pairs of L-BFGS, which stay on the device; function and objective are at
  /// the last point. No step follows but after go_on().
  void leave();
  /// From the same point, where value and gradient are what `state` has.
  void go_on();
  /// The pairs of the function before, as FitFunction::adopt() has them; both are on the device.
  void adopt(Steps& before);

 private:
  struct OnDevice;
  Objective& objective_;
  FitFunction& function_;
  OptimiserState& state_;
  OptimiserOptions options_;
  std::unique_ptr<OnDevice> device_;  ///< null: the host's
};

}  // namespace kappamu::inverse
