// A medium from logarithms that the device holds, and the gradient by them, which stays there:
// derivatives.h by kernels (grid_gradient.cl). For devices with double precision.
#pragma once

#include <array>
#include <span>

#include "device/buffer_pool.h"
#include "device/context.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"

namespace kappamu::forward {

/// grid_gradient.cl and grid_samples.cl, which compute in double, for a solver's numbers.
device::Program& double_program(device::Context& context, const Format& format);

class DeviceGradient {
 public:
  DeviceGradient(device::Context& context, const Format& format, const GridSetup& setup,
                 const BoundaryConstants& constants);

  /// κ and μ in the solver's numbers. Keeps the logarithms.
  void set_coefficients(const device::Buffer& logs, const device::Buffer& kappa,
                        const device::Buffer& mu);
  /// The logarithms kept.
  CoefficientPair medium() const;

  /// AdjointSums::observed of weights and exitance [pattern][face][sample] under `light`.
  device::Buffer observed(int patterns, std::span<const Face> seen, const device::Buffer& weights,
                          const device::Buffer& exitance, const device::Buffer& light) const;
  /// `products` and `columns` are FieldSums' of the medium.
  void add(const std::array<device::Buffer, 4>& products, const device::Buffer& columns,
           std::span<const Face> seen, const device::Buffer& observed,
           const device::Buffer& gradient) const;

 private:
  void add_entry(const device::Buffer& columns, const device::Buffer& gradient) const;
  void add_beam(const device::Buffer& columns, const device::Buffer& gradient) const;
  std::size_t bytes() const { return 2 * setup_.shape.cells() * sizeof(double); }

  device::Context& context_;
  Format format_;
  GridSetup setup_;
  BoundaryConstants constants_;
  device::Buffer logs_;
  mutable device::BufferPool pool_;
};

}  // namespace kappamu::forward
