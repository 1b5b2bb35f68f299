// Conjugate gradients of a batch of lights on the device (polygrid.cl).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "device/context.h"
#include "forward/polygrid/opencl/device_numbers.h"
#include "forward/polygrid/opencl/former_answers.h"
#include "forward/polygrid/opencl/opencl_solver.h"

namespace kappamu::forward::polygrid {

/// One batch on the device: its numbers, fields and work.
class BatchSolve {
 public:
  BatchSolve(device::Context& context, const Numbers& numbers, const linear::Lanes& lanes,
             const DevicePattern& matrix, const std::vector<DeviceLevel>& levels, Lights lights);

  const linear::Lanes& lanes() const { return lanes_; }

  /// `rows`: those of the finest level whose numbers have changed.
  void set_media(const std::vector<MediumValues>& media, const std::vector<ChannelLevels>& levels,
                 std::span<const int> rows);

  /// Adds what came of `lights` of all loads to `report`.
  void solve(const std::vector<Load>& loads, const std::vector<std::size_t>& lights,
             std::vector<std::vector<double>>& x, double tolerance, int most_iterations,
             CgReport& report);

 private:
  std::size_t rows() const { return static_cast<std::size_t>(matrix_.rows); }
  /// Of a field up to the end of its last block, 16 rows more at least (polygrid.cl).
  std::size_t field_bytes(std::size_t rows) const {
    return (rows / 16 + 2) * 16 * lanes_.width * numbers_.real_bytes();
  }

  /// The answer x, which is left to it, with its image b − r.
  void keep(const device::Buffer& r);
  /// Writes number(channel, row, slot) of some rows to [slot][row]; with `every_lane` for each lane
  /// of a field, even where all have one medium.
  template <class Number>
  void write_rows(const device::Buffer& buffer, std::size_t slots, std::span<const int> rows,
                  const Number& number, bool every_lane = false);
  Scalars dot(const device::Buffer& a, const device::Buffer& b) {
    return sums(1, "dot_product", a, b)[0];
  }

  /// An item per number in [0, count).
  template <class... T>
  void over(std::size_t count, const char* kernel, const T&... arguments) {
    context_.launch(program_, kernel, {count, 1, 64, 1}, static_cast<int>(count), arguments...);
  }
  /// Rows in [0, count) in runs.
  template <class... T>
  void in_runs(std::size_t count, const char* kernel, const T&... arguments) {
    context_.launch(program_, kernel, {runs_, 1, 1, 1}, static_cast<int>(count),
                    static_cast<int>(runs_), arguments...);
  }
  /// Σ per lane of a kernel that leaves partial sums of `count` kinds.
  template <class... T>
  std::vector<Scalars> sums(std::size_t count, const char* kernel, const T&... arguments) {
    in_runs(rows(), kernel, arguments..., partial_);
    return numbers_.double_sums ? read_sums<double>(count) : read_sums<float>(count);
  }
  template <class T>
  std::vector<Scalars> read_sums(std::size_t count) {
    std::vector<T> parts(count * runs_ * lanes_.width);
    context_.read(partial_, parts.data(), parts.size() * sizeof(T));
    std::vector<Scalars> total(count, Scalars(lanes_.width, 0.0));
    for (std::size_t k = 0; k < parts.size(); ++k) {
      total[k / (runs_ * lanes_.width)][k % lanes_.width] += static_cast<double>(parts[k]);
    }
    return total;
  }
  template <std::size_t count>
  void write(const std::array<Scalars, count>& values) {
    Scalars all;
    for (const Scalars& of_lanes : values) all.insert(all.end(), of_lanes.begin(), of_lanes.end());
    if (numbers_.double_sums) {
      context_.write(scalars_, all.data(), all.size() * sizeof(double));
    } else {
      const std::vector<float> single(all.begin(), all.end());
      context_.write(scalars_, single.data(), single.size() * sizeof(float));
    }
  }

  /// From the residual r of the finest level to its correction z; r·z.
  Scalars cycle();

  device::Context& context_;
  Numbers numbers_;
  linear::Lanes lanes_;
  const DevicePattern& matrix_;
  const std::vector<DeviceLevel>& levels_;
  device::Program& program_;
  std::size_t runs_ = 1;
  device::Buffer value_, coarsest_;
  std::vector<device::Buffer> links_, inverse_diagonal_, level_r_, level_y_;  ///< [level]
  device::Buffer b_, x_, z_, p_, image_, partial_, scalars_;
  device::Buffer fresh_, fresh_row_;  ///< what write_rows() takes over, [row][slot]
  std::optional<FormerAnswers> former_;
};

}  // namespace kappamu::forward::polygrid
