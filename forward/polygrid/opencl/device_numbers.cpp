#include "forward/polygrid/opencl/device_numbers.h"

#include <Eigen/Cholesky>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/embedded/opencl/device_levels.h"

namespace kappamu::forward::polygrid {

using embedded::uploaded;

namespace {

template <class T>
void write_as(device::Context& context, const device::Buffer& buffer,
              const std::vector<const std::vector<double>*>& of_lane, std::size_t width,
              Stretch stretch) {
  // A part of a buffer begins at a multiple of what devices ask for.
  constexpr std::size_t per_part = device::Context::part_alignment / sizeof(T);
  stretch.begin -= stretch.begin * width % per_part / width;
  std::vector<T> lanes((stretch.end - stretch.begin) * width, T(0));
  embedded::for_row_ranges(stretch.end - stretch.begin, [&](std::size_t begin, std::size_t end) {
    for (std::size_t lane = 0; lane < of_lane.size(); ++lane) {
      const double* from = of_lane[lane]->data() + stretch.begin;
      for (std::size_t i = begin; i < end; ++i) {
        lanes[i * width + lane] = static_cast<T>(from[i]);
      }
    }
  });
  const std::size_t bytes = lanes.size() * sizeof(T);
  context.write(context.part(buffer, stretch.begin * width * sizeof(T), bytes), lanes.data(),
                bytes);
}

template <class T>
void read_as(device::Context& context, const device::Buffer& buffer,
             const std::vector<std::vector<double>*>& of_lane, std::size_t width) {
  const std::size_t rows = of_lane.front()->size();
  std::vector<T> lanes(rows * width);
  context.read(buffer, lanes.data(), lanes.size() * sizeof(T));
  embedded::for_row_ranges(rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t lane = 0; lane < of_lane.size(); ++lane) {
      double* to = of_lane[lane]->data();
      for (std::size_t i = begin; i < end; ++i)
        to[i] = static_cast<double>(lanes[i * width + lane]);
    }
  });
}

}  // namespace

std::string Numbers::build_options(const embedded::Lanes& lanes) const {
  return std::string("-DREAL=") + (precision == Precision::single ? "float" : "double") +
         " -DSUM=" + (double_sums ? "double" : "float") +
         " -DWIDTH=" + std::to_string(lanes.width) + " -DOWN=" + (lanes.own() ? "1" : "0") +
         " -DINTERLEAVED=" + (interleaved ? "1" : "0");
}

void write_lanes(device::Context& context, const device::Buffer& buffer, const Numbers& numbers,
                 const std::vector<const std::vector<double>*>& of_lane, std::size_t width,
                 std::optional<Stretch> stretch) {
  const Stretch which = stretch.value_or(Stretch{0, of_lane.front()->size()});
  if (which.begin == which.end) return;
  if (numbers.precision == Precision::single) {
    write_as<float>(context, buffer, of_lane, width, which);
  } else {
    write_as<double>(context, buffer, of_lane, width, which);
  }
}

void read_lanes(device::Context& context, const device::Buffer& buffer, const Numbers& numbers,
                const std::vector<std::vector<double>*>& of_lane, std::size_t width) {
  if (numbers.precision == Precision::single) {
    read_as<float>(context, buffer, of_lane, width);
  } else {
    read_as<double>(context, buffer, of_lane, width);
  }
}

DevicePattern::DevicePattern(device::Context& context, const Pattern& pattern)
    : rows(static_cast<int>(pattern.rows())),
      entries(pattern.column.size()),
      start(uploaded(context, pattern.start)),
      column(uploaded(context, pattern.column)) {}

DeviceLevel::DeviceLevel(device::Context& context, const GraphLevel& level, std::size_t coarser)
    : links(context, level.links) {
  if (coarser == 0) return;
  std::vector<int> first(coarser + 1, 0), children(level.parent.size());
  for (const int p : level.parent) ++first[static_cast<std::size_t>(p) + 1];
  for (std::size_t p = 0; p < coarser; ++p) first[p + 1] += first[p];
  std::vector<int> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < children.size(); ++i) {
    children[static_cast<std::size_t>(next[static_cast<std::size_t>(level.parent[i])]++)] =
        static_cast<int>(i);
  }
  first_child = uploaded(context, first);
  child = uploaded(context, children);
}

ChannelLevels::ChannelLevels(const Hierarchy& hierarchy, const MediumValues& medium)
    : graph(hierarchy.values(medium)) {
  for (const GraphValues& level : graph) {
    inverse_diagonal.push_back(level.diagonal);
    for (double& d : inverse_diagonal.back()) d = 1.0 / d;
  }
  const Pattern& links = hierarchy.level().back().links;
  const auto rows = static_cast<Eigen::Index>(links.rows());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto row = static_cast<std::size_t>(i);
    matrix(i, i) = graph.back().diagonal[row];
    for (int k = links.start[row]; k < links.start[row + 1]; ++k) {
      matrix(i, links.column[static_cast<std::size_t>(k)]) =
          -graph.back().link[static_cast<std::size_t>(k)];
    }
  }
  const Eigen::MatrixXd inverse = matrix.llt().solve(Eigen::MatrixXd::Identity(rows, rows));
  coarsest.assign(inverse.data(), inverse.data() + inverse.size());
}

}  // namespace kappamu::forward::polygrid
