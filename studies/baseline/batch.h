// A batch of patterns on a device as the baselines keep it: [cell][lane], patterns innermost.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "device/context.h"
#include "forward/grid/grid_solver.h"
#include "studies/baseline/stencil.h"

namespace kappamu::studies::baseline {

using namespace forward;

/// `count` patterns from `first` on, computed in `lanes` ≥ count lanes (16, 8, 4 or 1).
struct Lanes {
  int first = 0;
  int count = 0;
  int lanes = 1;
};
std::vector<Lanes> cut_into_lanes(int patterns);

/// A stencil on the device.
struct DeviceStencil {
  std::array<int, 3> n{};
  device::Buffer gx, gy, gz, sink, inverse;
  std::size_t cells() const {
    return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) *
           static_cast<std::size_t>(n[2]);
  }
};

/// The kernels of baseline.cl for one precision and number of lanes, with what launching needs.
class Batch {
 public:
  /// Throws InputError where double is asked of a device without it.
  Batch(device::Context& context, Precision precision, Lanes lanes);

  device::Context& context() const { return context_; }
  Precision precision() const {
    return single_ ? Precision::single_precision : Precision::double_precision;
  }
  int patterns() const { return lanes_.count; }
  int first() const { return lanes_.first; }  ///< pattern of the problem in lane 0

  DeviceStencil upload(const Stencil& stencil) const;
  device::Buffer upload(std::span<const double> values) const;

  device::Buffer make_field(std::size_t cells) const;  ///< zero
  device::Buffer make_accurate_field(std::size_t cells) const;
  device::Buffer make_partial_sums() const;
  device::Buffer make_scalars() const;

  /// Between host [pattern][cell], all patterns of the problem, and this batch's field.
  void write(const device::Buffer& field, std::size_t cells, std::span<const double> values) const;
  void read(const device::Buffer& field, std::size_t cells, std::span<double> values) const;
  void read_accurate(const device::Buffer& field, std::size_t cells,
                     std::span<double> values) const;
  void write_scalars(const device::Buffer& scalars, std::span<const double> values) const;
  /// Σ over runs, one value per lane.
  std::vector<double> sum(const device::Buffer& partial) const;

  int runs() const { return gpu_ ? 4096 : 256; }
  /// Launches over segments of rows, over runs, over single cells (baseline.cl).
  template <class... T>
  void sweep(const char* kernel, const std::array<int, 3>& n, const T&... arguments) const {
    context_.launch(*program_, kernel, rows(n), n[0], n[1], n[2], arguments...);
  }
  template <class... T>
  void over_runs(const char* kernel, const T&... arguments) const {
    context_.launch(*program_, kernel, items(static_cast<std::size_t>(runs())), arguments...);
  }
  template <class... T>
  void over_cells(const char* kernel, std::size_t cells, const T&... arguments) const {
    context_.launch(*program_, kernel, items(cells), arguments...);
  }

 private:
  device::Range rows(const std::array<int, 3>& n) const;
  device::Range items(std::size_t count) const;
  device::Buffer zeros(std::size_t bytes) const;

  device::Context& context_;
  Lanes lanes_;
  bool gpu_;
  bool single_;    ///< storage: float or double
  bool accurate_;  ///< sums in double, or in float where the device has no double
  std::size_t groups_;
  device::Program* program_;
};

}  // namespace kappamu::studies::baseline
