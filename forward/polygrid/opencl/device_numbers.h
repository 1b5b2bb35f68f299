// What a polygrid's equations and their hierarchy are in the device's memory.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "forward/embedded/opencl/lanes.h"
#include "forward/polygrid/equations/hierarchy.h"
#include "forward/polygrid/opencl/opencl_solver.h"

namespace kappamu::forward::polygrid {

/// How numbers are kept and sums are made.
struct Numbers {
  Precision precision = Precision::single;
  bool double_sums = true, interleaved = false;

  std::size_t real_bytes() const { return precision == Precision::single ? 4 : 8; }
  std::size_t sum_bytes() const { return double_sums ? 8 : 4; }
  /// Those of polygrid.cl for a batch's lanes.
  std::string build_options(const embedded::Lanes& lanes) const;
};

/// Part of a vector's elements.
struct Stretch {
  std::size_t begin = 0, end = 0;
};
/// Writes a stretch of `of_lane`, or all of it, beside each other, [row][lane]; lanes without are
/// zero.
void write_lanes(device::Context& context, const device::Buffer& buffer, const Numbers& numbers,
                 const std::vector<const std::vector<double>*>& of_lane, std::size_t width,
                 std::optional<Stretch> stretch = {});
/// Reads what is [row][width] into the lanes' own vectors, which have their size.
void read_lanes(device::Context& context, const device::Buffer& buffer, const Numbers& numbers,
                const std::vector<std::vector<double>*>& of_lane, std::size_t width);

struct DevicePattern {
  DevicePattern(device::Context& context, const Pattern& pattern);

  int rows = 0;
  std::size_t entries = 0;
  device::Buffer start, column;
};

struct DeviceLevel {
  /// `coarser`: rows of the next level; 0: this is the coarsest.
  DeviceLevel(device::Context& context, const GraphLevel& level, std::size_t coarser);

  DevicePattern links;
  device::Buffer first_child, child;  ///< none on the coarsest
};

/// What a channel's medium is on the levels, on the host.
struct ChannelLevels {
  ChannelLevels(const Hierarchy& hierarchy, const MediumValues& medium);

  std::vector<GraphValues> graph;
  std::vector<std::vector<double>> inverse_diagonal;  ///< [level]
  std::vector<double> coarsest;                       ///< inverse of the coarsest level's matrix
};

}  // namespace kappamu::forward::polygrid
