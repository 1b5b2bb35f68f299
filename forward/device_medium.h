// The medium of an operator and derivatives by it, in the memory of the operator's device. A fit
// whose vectors live there moves none of them to the host between its steps.
#pragma once

#include <span>

#include "device/context.h"
#include "forward/operator.h"

namespace kappamu::forward {

/// A pair of fields is a buffer of doubles [2][z][y][x]: log κ (κ in mm) and log μ (μ in 1/mm), or
/// derivatives by them.
class DeviceMedium {
 public:
  virtual ~DeviceMedium() = default;

  virtual device::Context& context() const = 0;
  /// DiffusionOperator::set_medium() of logarithms, all finite.
  virtual void set(const device::Buffer& logs) = 0;
  /// DiffusionOperator::add_gradient().
  virtual void add_gradient(const SolvedBatch& at, const BatchField& lambda,
                            std::span<const double> weights,
                            const device::Buffer& gradient) const = 0;
};

}  // namespace kappamu::forward
