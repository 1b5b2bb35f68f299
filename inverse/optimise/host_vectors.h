// The vectors of L-BFGS in the host's memory: those of an OptimiserState.
#pragma once

#include "inverse/optimise/lbfgs.h"
#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse {

class HostVectors final : public StepVectors {
 public:
  HostVectors(Function& function, OptimiserState& state) : function_(function), state_(state) {}

  std::size_t pairs() const override { return state_.steps.size(); }
  std::vector<double> products(std::size_t k) override;
  double set_direction(const Combination& of) override;
  double amplitude() override { return function_.amplitude(state_.z, direction_); }
  double value_at(double length) override;
  void accept() override;
  void forget_pairs() override;
  void forget_oldest_pair() override;

  const Vector& direction() const { return direction_; }

 private:
  Function& function_;
  OptimiserState& state_;
  Vector direction_;
  Vector trial_;  ///< z of the last value_at()
};

}  // namespace kappamu::inverse
