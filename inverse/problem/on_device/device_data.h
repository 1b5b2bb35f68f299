// Light, exitance and data of an objective in the memory of its operator's device, batch by batch
// as they are solved. The data term of independent Gaussian errors (data_term.h) is a kernel there;
// of any other the exitance is read and the derivatives by it are written.
#pragma once

#include <cstddef>
#include <vector>

#include "inverse/kernels/device_arithmetic.h"

namespace kappamu::inverse {

class DeviceData {
 public:
  /// Surface values of one batch, [pattern][...].
  struct Batch {
    device::Buffer light, exitance, by_exitance;
    device::Buffer data, weight, ratio;  ///< of the pictures; empty before set_data()
    std::size_t values;                  ///< of exitance
  };

  /// Of `light` [L][light_size], solved `at_once` patterns at a time, which leaves `exitance_size`
  /// values a pattern.
  DeviceData(device::Context& context, const std::vector<double>& light, int lights, int at_once,
             std::size_t exitance_size);

  const Batch& operator[](std::size_t batch) const { return batches_[batch]; }

  /// For misfit(): data, weights and r, one for each value of exitance.
  void set_data(const std::vector<double>& data, const std::vector<double>& weight,
                const std::vector<double>& ratio);
  /// Σ w (r M − d)²; sets the derivatives of half of it by exitance.
  double misfit();

  device::Buffer upload(const CoefficientPair& fields) { return arithmetic_.upload(fields); }
  CoefficientPair download(const device::Buffer& fields, std::size_t cells) const {
    return arithmetic_.download(fields, cells);
  }
  device::Buffer zeros(std::size_t doubles);

  /// Exitance [L][exitance_size].
  std::vector<double> exitance() const;
  void set_by_exitance(const std::vector<double>& values);

 private:
  void write(device::Buffer Batch::*where, const std::vector<double>& values);

  DeviceArithmetic arithmetic_;
  std::vector<Batch> batches_;
};

}  // namespace kappamu::inverse
