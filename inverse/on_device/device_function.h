// FitFunction (optimise/fit_function.h) with all its vectors in the memory of a device: the medium
// is set, the regulariser and the gradient are computed and the coordinates are changed there.
#pragma once

#include <optional>

#include "inverse/on_device/device_basis.h"
#include "inverse/optimise/absorption_scale.h"
#include "inverse/problem/objective.h"
#include "inverse/regulariser/roughness.h"

namespace kappamu::inverse {

/// What is minimised besides the data term.
struct DeviceTerms {
  Anchor anchor;
  double weight = 0.0;  ///< α
  Regulariser regulariser;
  AbsorptionScale scale;
};

class DeviceFunction {
 public:
  /// The objective's operator must have a device; R must not be [W]'s. `basis` must outlive this.
  DeviceFunction(DeviceArithmetic& arithmetic, Objective& objective, const Basis& basis,
                 const DeviceTerms& terms);

  std::size_t size() const { return basis_.size(); }
  void to_fields(const device::Buffer& z, const device::Buffer& fields);
  /// At these fields; gradient() is by z, there.
  double value(const device::Buffer& fields);
  void gradient(const device::Buffer& fields, const device::Buffer& by_z);
  /// FitFunction::adopt() of a pair, in place, where `fields` are those that it begins from.
  void adopt(DeviceFunction& before, const device::Buffer& fields, const device::Buffer& step,
             const device::Buffer& change);
  /// R of the last value() or adopt().
  double roughness() const { return roughness_; }

 private:
  void set_roughness(const device::Buffer& fields);
  void by_scaled(const device::Buffer& fields, const device::Buffer& by_fields);

  DeviceArithmetic& arithmetic_;
  Objective& objective_;
  DeviceBasis basis_;
  DeviceTerms terms_;
  GridShape shape_;
  double scale_;  ///< h/ℓ
  double pull_;   ///< that times (h/L)²
  double edge_;   ///< of Huber-TV, per voxel; 0: H1
  double roughness_ = 0.0;
  device::Buffer diffusivity_;
};

}  // namespace kappamu::inverse
