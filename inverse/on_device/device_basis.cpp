#include "inverse/on_device/device_basis.h"

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "core/error.h"
#include "core/numbers/cosine_transform.h"
#include "core/parallel.h"

namespace kappamu::inverse {

namespace {

constexpr std::size_t tile = 64, side = 16;  // TILE and SIDE in waves.cl

template <class T>
device::Buffer uploaded(device::Context& context, const std::vector<T>& values) {
  device::Buffer buffer = context.allocate(values.size() * sizeof(T));
  context.write(buffer, values.data(), values.size() * sizeof(T));
  return buffer;
}

/// [frequency][value]
device::Buffer cosines_of(device::Context& context, int n) {
  const Eigen::MatrixXd columns =
      CosineTransform(n).forward(Eigen::MatrixXd::Identity(n, n)).transpose();
  return uploaded(context, std::vector<double>(columns.data(), columns.data() + columns.size()));
}

}  // namespace

DeviceBasis::DeviceBasis(DeviceArithmetic& arithmetic, const MediumSpace& space, const Basis& basis)
    : arithmetic_(arithmetic), basis_(basis) {
  check(basis.waves() != nullptr && space.fraction.empty(), "voxels have no waves");
  const LateralWaves& waves = *basis.waves();
  rows_ = waves.rows();
  waves_ = waves.waves();
  const int axis_a = space.depth_axis == 0 ? 1 : 0, axis_b = space.depth_axis == 2 ? 1 : 2;
  const GridShape& s = space.shape;
  const std::array<int, 3> stride{1, s.nx, s.nx * s.ny};
  const auto along = [&](int axis) { return stride[static_cast<std::size_t>(axis)]; };
  device::Context& context = arithmetic.context();
  a_ = {s.extent(axis_a), cosines_of(context, s.extent(axis_a))};
  b_ = {s.extent(axis_b), cosines_of(context, s.extent(axis_b))};
  check(a_.n * b_.n == waves_, "the basis is of a part of the block");
  const int depth = waves.depth(), cells = static_cast<int>(s.cells());
  fields_a_ = {along(axis_a), along(axis_b), depth, along(space.depth_axis), cells};
  fields_b_ = {along(axis_b), along(axis_a), depth, along(space.depth_axis), cells};
  waves_b_ = {a_.n * rows_, rows_, rows_, 1, 0};
  std::vector<int> bin(static_cast<std::size_t>(waves_));
  for (int k = 0; k < waves.bins(); ++k) {
    for (const int wave : waves.members(k)) bin[static_cast<std::size_t>(wave)] = k;
  }
  bin_ = uploaded(context, bin);
  std::vector<Eigen::MatrixXd> inverse(static_cast<std::size_t>(waves.bins()));
  const auto of = [&](int k) -> Eigen::MatrixXd& { return inverse[static_cast<std::size_t>(k)]; };
  for_rows(waves.bins(), [&](int k) { of(k) = basis.inverse_factor(k); });
  inverse_ = of_bins([&](int k) { return of(k); });
  transposed_ = of_bins([&](int k) { return of(k).transpose().eval(); });
}

/// One matrix for each bin, [bin][column][row].
template <class Matrix>
device::Buffer DeviceBasis::of_bins(const Matrix& matrix) const {
  const int bins = basis_.waves()->bins();
  const std::size_t size = static_cast<std::size_t>(rows_) * static_cast<std::size_t>(rows_);
  std::vector<double> values(size * static_cast<std::size_t>(bins));
  for_rows(bins, [&](int k) {
    const Eigen::MatrixXd of_bin = matrix(k);
    std::copy_n(of_bin.data(), size, values.data() + size * static_cast<std::size_t>(k));
  });
  return uploaded(arithmetic_.context(), values);
}

void DeviceBasis::along(const Axis& axis, int others, bool transposed, const Place& from,
                        const Place& to, const device::Buffer& source,
                        const device::Buffer& target) {
  const auto tiles = [](int count) {
    return (static_cast<std::size_t>(count) + tile - 1) / tile * side;
  };
  arithmetic_.launch("along_axis", {tiles(others * rows_), tiles(axis.n), side, side}, axis.n,
                     others, rows_, int{transposed}, axis.cosines, from.axis, from.other,
                     from.depth, from.step, from.jump, to.axis, to.other, to.depth, to.step,
                     to.jump, source, target);
}

void DeviceBasis::by_bins(bool upper, const device::Buffer& matrices, const device::Buffer& from,
                          const device::Buffer& to) {
  arithmetic_.launch("by_bins", {size(), 1, 64, 1}, waves_, rows_, int{upper}, bin_, matrices, from,
                     to);
}

void DeviceBasis::to_fields(const device::Buffer& z, const device::Buffer& fields) {
  const device::Buffer coefficients = arithmetic_.take(size()), half = arithmetic_.take(size());
  by_bins(true, inverse_, z, coefficients);
  along(b_, a_.n, true, waves_b_, fields_b_, coefficients, half);
  along(a_, b_.n, true, fields_a_, fields_a_, half, fields);
}

void DeviceBasis::carry(DeviceBasis& before, const device::Buffer& z) {
  if (!factors_) factors_ = of_bins([&](int k) { return basis_.factor(k); });
  const device::Buffer between = arithmetic_.take(size());
  before.by_bins(true, before.inverse_, z, between);
  by_bins(true, factors_, between, z);
}

void DeviceBasis::carry_gradient(DeviceBasis& before, const device::Buffer& by_z) {
  device::Buffer& off = before.factors_transposed_;
  if (!off) off = of_bins([&](int k) { return before.basis_.factor(k).transpose().eval(); });
  const device::Buffer between = arithmetic_.take(size());
  before.by_bins(false, off, by_z, between);
  by_bins(false, transposed_, between, by_z);
}

void DeviceBasis::gradient(const device::Buffer& by_field, const device::Buffer& by_z) {
  const device::Buffer half = arithmetic_.take(size()), coefficients = arithmetic_.take(size());
  along(a_, b_.n, false, fields_a_, fields_a_, by_field, half);
  along(b_, a_.n, false, fields_b_, waves_b_, half, coefficients);
  by_bins(false, transposed_, coefficients, by_z);
}

}  // namespace kappamu::inverse
