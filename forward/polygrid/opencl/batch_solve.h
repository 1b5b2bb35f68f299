// Conjugate gradients of a batch of lights on the device (polygrid.cl).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "forward/polygrid/opencl/device_numbers.h"
#include "forward/polygrid/opencl/former_answers.h"
#include "forward/polygrid/opencl/opencl_solver.h"

namespace kappamu::forward::polygrid {

/// One batch on the device: its numbers, fields and work.
class BatchSolve : linear::DeviceLanes {
 public:
  BatchSolve(device::Context& context, const linear::Numbers& numbers, const linear::Lanes& lanes,
             const DevicePattern& matrix, const std::vector<DeviceLevel>& levels, Lights lights);

  using DeviceLanes::lanes;

  /// `rows`: those of the finest level whose numbers have changed.
  void set_media(const std::vector<MediumValues>& media, const std::vector<ChannelLevels>& levels,
                 std::span<const int> rows);

  /// Adds what came of `lights` of all loads to `report`.
  void solve(const std::vector<Load>& loads, const std::vector<std::size_t>& lights,
             std::vector<std::vector<double>>& x, linear::CgEnd ends, CgReport& report);

  // What conjugate_gradients() asks for.
  void precondition();  ///< a V-cycle, from r of the finest level to z
  void direct();
  void advance();

 private:
  /// Of a field up to the end of its last block, 16 rows more at least (polygrid.cl).
  std::size_t field_bytes(std::size_t rows) const {
    return (rows / 16 + 2) * 16 * width() * numbers_.real_bytes();
  }
  /// x and r from former answers, or from the multiple of `starts` that has the least error.
  void start(const std::vector<const std::vector<double>*>& starts);

  /// The answer x, which is left to it, with its image b − r.
  void keep(const device::Buffer& r);
  /// Writes some rows to [slot][row]: numbers(channel, row, put) calls put(slot, number) for what
  /// is not 0. With `every_lane` for each lane of a field, even where all have one medium.
  template <class Numbers>
  void write_rows(const device::Buffer& buffer, std::size_t slots, std::span<const int> rows,
                  const Numbers& numbers, bool every_lane = false);
  Scalars dot(const device::Buffer& a, const device::Buffer& b) {
    return sums(1, "dot_product", a, b)[0];
  }
  template <class... T>
  void over(std::size_t count, const char* kernel, const T&... arguments) {
    DeviceLanes::over(program_, count, kernel, arguments...);
  }
  template <class... T>
  void in_runs(std::size_t count, const char* kernel, const T&... arguments) {
    DeviceLanes::in_runs(program_, count, kernel, arguments...);
  }
  template <class... T>
  std::vector<Scalars> sums(std::size_t count, const char* kernel, const T&... arguments) {
    return DeviceLanes::sums(program_, count, kernel, arguments...);
  }
  template <class... T>
  void sum_to(linear::Place place, const char* kernel, const T&... arguments) {
    DeviceLanes::sum_to(place, program_, kernel, arguments...);
  }

  const DevicePattern& matrix_;
  const std::vector<DeviceLevel>& levels_;
  device::Program& program_;
  device::Buffer value_, coarsest_;
  std::vector<device::Buffer> links_, inverse_diagonal_, level_r_, level_y_;  ///< [level]
  device::Buffer b_, x_, z_, p_, image_;
  device::Buffer fresh_, fresh_row_;  ///< what write_rows() takes over, [row][slot]
  std::optional<FormerAnswers> former_;
  bool first_direction_ = true;
};

}  // namespace kappamu::forward::polygrid
