// The kernels of a fit's vectors (vectors.cl), their sums on the host.
#pragma once

#include <cstddef>
#include <vector>

#include "device/buffer_pool.h"
#include "device/context.h"
#include "inverse/problem/fields.h"

namespace kappamu::inverse {

class DeviceArithmetic {
 public:
  explicit DeviceArithmetic(device::Context& context);

  device::Context& context() const { return context_; }
  /// For as many doubles; returned to the next that asks when its last owner is gone.
  device::Buffer take(std::size_t doubles) { return pool_.take(doubles * sizeof(double)); }
  /// A pair of fields [2][z][y][x], and back.
  device::Buffer upload(const CoefficientPair& fields);
  CoefficientPair download(const device::Buffer& fields, std::size_t cells) const;

  /// A kernel with one item per element of `count`, which is its first argument.
  template <class... T>
  void each(const char* kernel, std::size_t count, const T&... arguments) {
    context_.launch(program_, kernel, {count, 1, 64, 1}, static_cast<int>(count), arguments...);
  }
  /// A kernel of another index space or other first arguments.
  template <class... T>
  void launch(const char* kernel, const device::Range& range, const T&... arguments) {
    context_.launch(program_, kernel, range, arguments...);
  }
  /// A reduction over `count` elements to `kinds` numbers, the first `maxima` of them the largest
  /// of their elements, the others sums, written to result[first] and on. Its last argument is
  /// where groups leave theirs.
  template <class... T>
  void reduce_into(const device::Buffer& result, std::size_t first, const char* kernel,
                   std::size_t count, std::size_t kinds, std::size_t maxima,
                   const T&... arguments) {
    const std::size_t groups = groups_of(count);
    const device::Buffer partial = take(kinds * groups);
    context_.launch(program_, kernel, {groups * group_items, 1, group_items, 1}, arguments...,
                    partial);
    context_.launch(program_, "finish", {kinds * group_items, 1, group_items, 1},
                    static_cast<int>(groups), static_cast<int>(maxima), static_cast<int>(first),
                    partial, result);
  }
  std::vector<double> read(const device::Buffer& numbers, std::size_t count) const;
  /// The same, read at once.
  template <class... T>
  std::vector<double> reduce(const char* kernel, std::size_t count, std::size_t kinds,
                             std::size_t maxima, const T&... arguments) {
    const device::Buffer result = take(kinds);
    reduce_into(result, 0, kernel, count, kinds, maxima, arguments...);
    return read(result, kinds);
  }

 private:
  static constexpr std::size_t group_items = 128;  // GROUP in vectors.cl, 16 elements an item
  static std::size_t groups_of(std::size_t count) {
    return (count + 16 * group_items - 1) / (16 * group_items);
  }

  device::Context& context_;
  device::Program& program_;
  device::BufferPool pool_;
};

}  // namespace kappamu::inverse
