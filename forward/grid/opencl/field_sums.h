// Sums over the patterns or the voxels of fields on the device: what gradients and power balances
// are made of. GridSolver's functions of the same names (grid_solver.h).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "device/buffer_pool.h"
#include "device/context.h"
#include "forward/grid/opencl/opencl_field.h"
#include "forward/grid/opencl/trusted_kernels.h"

namespace kappamu::forward {

class FieldSums {
 public:
  FieldSums(device::Context& context, const Format& format, const GridSetup& setup,
            TrustedKernels& kernels, device::BufferPool& pool);

  /// Σ_m λ_i φ_i and the sums across faces towards +x, +y, +z, in the device's accumulators.
  std::array<device::Buffer, 4> products(const OpenclField& lambda, const OpenclField& phi) const;
  /// Σ_m λ_i E_m of the columns below the lit face, whose light is given.
  device::Buffer columns(const OpenclField& lambda, const SamplesOf& light) const;

  PairProducts pair_products(const OpenclField& lambda, const OpenclField& phi) const;
  std::vector<double> column_products(const OpenclField& lambda, const SamplesOf& light) const;
  std::vector<double> weighted_sums(const OpenclField& phi, std::span<const double> weight) const;

 private:
  device::Buffer zeros() const;
  std::vector<double> read(const device::Buffer& sums) const;

  device::Context& context_;
  Format format_;
  GridSetup setup_;
  TrustedKernels& kernels_;
  device::BufferPool& pool_;
};

}  // namespace kappamu::forward
