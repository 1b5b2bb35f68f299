// The vectors of L-BFGS in the memory of a device, with the fields at z and along the direction.
#pragma once

#include <vector>

#include "inverse/on_device/device_function.h"
#include "inverse/optimise/lbfgs.h"
#include "inverse/optimise/optimiser.h"

namespace kappamu::inverse {

class DeviceVectors final : public StepVectors {
 public:
  /// From what `state` holds. `fields`: those of state.z where they are no function of it, empty
  /// otherwise.
  DeviceVectors(DeviceArithmetic& arithmetic, DeviceFunction& function, const OptimiserState& state,
                const CoefficientPair& fields);

  /// The pairs of the function before, as this one has them; `before` loses its own. Those of no
  /// positive curvature are left out. All pairs that were here are gone.
  void adopt(DeviceVectors& before);
  /// The gradient becomes that of `state`, which stands here.
  void set_gradient(const OptimiserState& state);
  /// z and the gradient.
  void store(OptimiserState& state) const;
  void store_pairs(OptimiserState& state) const;
  /// Of z.
  CoefficientPair fields() const;
  /// f there.
  double solve();
  /// Whether the objective's last value() was there.
  bool solved_here() const { return solved_here_; }

  std::size_t pairs() const override { return pairs_.size(); }
  std::vector<double> products(std::size_t k) override;
  double set_direction(const Combination& of) override;
  double amplitude() override;
  double value_at(double length) override;
  void accept() override;
  void forget_pairs() override { pairs_.clear(); }
  void forget_oldest_pair() override { pairs_.erase(pairs_.begin()); }

 private:
  struct Point {
    device::Buffer z, fields;
  };
  struct Pair {
    device::Buffer step, change;  ///< float
  };
  template <class Values>
  void download(const device::Buffer& buffer, Values& values) const;
  device::Buffer take() const { return arithmetic_.take(size_); }
  device::Buffer take_floats() const { return arithmetic_.take((size_ + 1) / 2); }
  Point moved(double length);
  device::Buffer difference(const device::Buffer& a, const device::Buffer& b) const;

  DeviceArithmetic& arithmetic_;
  DeviceFunction& function_;
  std::size_t size_;
  Point here_, trial_, ahead_;  ///< z, of the last value_at(), and z + direction
  bool solved_here_ = false;
  device::Buffer gradient_, direction_;
  std::vector<Pair> pairs_;
};

}  // namespace kappamu::inverse
