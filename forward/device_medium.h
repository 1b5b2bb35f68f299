// The medium of an operator and derivatives by it, in the memory of the operator's device. A fit
// whose vectors live there moves none of them to the host between its steps.
#pragma once

#include "device/context.h"
#include "forward/operator.h"

namespace kappamu::forward {

/// SolvedBatch with its surface values in the device's memory.
struct DeviceBatch {
  const BatchField& phi;
  const device::Buffer& light;
  const device::Buffer& exitance;
};

/// A pair of fields is a buffer of doubles [2][z][y][x]: log κ (κ in mm) and log μ (μ in 1/mm), or
/// derivatives by them. The host's copy of one:
inline CoefficientPair read_pair(device::Context& context, const device::Buffer& fields,
                                 std::size_t cells) {
  CoefficientPair pair;
  context.look(fields, 2 * cells * sizeof(double), [&](const void* memory) {
    const auto* const values = static_cast<const double*>(memory);
    pair.log_kappa.assign(values, values + cells);
    pair.log_mu.assign(values + cells, values + 2 * cells);
  });
  return pair;
}

/// Surface values are doubles, [pattern][light_size()] or [pattern][exitance_size()].
class DeviceMedium {
 public:
  virtual ~DeviceMedium() = default;

  virtual device::Context& context() const = 0;
  /// DiffusionOperator::set_medium() of logarithms, all finite.
  virtual void set(const device::Buffer& logs) = 0;
  /// DiffusionOperator's functions of the same names.
  virtual void load(const device::Buffer& light, BatchField& b) const = 0;
  virtual void exitance(const BatchField& phi, const device::Buffer& light,
                        const device::Buffer& out) const = 0;
  virtual void exitance_transpose(const device::Buffer& weights, BatchField& b) const = 0;
  virtual void add_gradient(const DeviceBatch& at, const BatchField& lambda,
                            const device::Buffer& weights,
                            const device::Buffer& gradient) const = 0;
};

}  // namespace kappamu::forward
