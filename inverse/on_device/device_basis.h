// Basis (optimise/basis.h) of a whole block in the memory of a device: cosine transforms as dense
// products, and each bin's triangular matrix and its inverse.
#pragma once

#include <array>

#include "inverse/kernels/device_arithmetic.h"
#include "inverse/optimise/basis.h"

namespace kappamu::inverse {

class DeviceBasis {
 public:
  /// Of a block whose basis has lateral waves; it must outlive this.
  DeviceBasis(DeviceArithmetic& arithmetic, const MediumSpace& space, const Basis& basis);

  std::size_t size() const { return static_cast<std::size_t>(rows_) * waves_; }
  /// Basis::to_fields() and Basis::gradient(), z and fields as they have them.
  void to_fields(const device::Buffer& z, const device::Buffer& fields);
  void gradient(const device::Buffer& by_field, const device::Buffer& by_z);
  /// Basis::carried() and Basis::carried_gradient(), in place.
  void carry(DeviceBasis& before, const device::Buffer& z);
  void carry_gradient(DeviceBasis& before, const device::Buffer& by_z);

 private:
  /// Where a value along an axis is found: place_of() in waves.cl.
  struct Place {
    int axis, other, depth, step, jump;
  };
  struct Axis {
    int n;
    device::Buffer cosines;  ///< [frequency][value]
  };
  void along(const Axis& axis, int others, bool transposed, const Place& from, const Place& to,
             const device::Buffer& source, const device::Buffer& target);
  void by_bins(bool upper, const device::Buffer& matrices, const device::Buffer& from,
               const device::Buffer& to);

  template <class Matrix>
  device::Buffer of_bins(const Matrix& matrix) const;

  DeviceArithmetic& arithmetic_;
  int rows_, waves_;
  Axis a_, b_;
  Place fields_a_, fields_b_, waves_b_;  ///< of fields along a and b, of coefficients along b
  device::Buffer bin_;                   ///< of each wave
  device::Buffer inverse_, transposed_;  ///< U⁻¹ and U⁻ᵀ of each bin, [bin][column][row]
  device::Buffer factors_, factors_transposed_;  ///< U and Uᵀ, made when first needed
  const Basis& basis_;
};

}  // namespace kappamu::inverse
