#include "forward/polygrid/opencl/device_numbers.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "forward/embedded/equations/row_ranges.h"
#include "forward/embedded/opencl/device_levels.h"

namespace kappamu::forward::polygrid {

using embedded::uploaded;

namespace {

template <class T>
void write_as(device::Context& context, const device::Buffer& buffer,
              const std::vector<const std::vector<double>*>& of_lane, std::size_t width) {
  const std::size_t rows = of_lane.front()->size();
  const auto lanes = std::make_unique_for_overwrite<T[]>(rows * width);
  embedded::for_row_ranges(rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t lane = 0; lane < width; ++lane) {
      const double* from = lane < of_lane.size() ? of_lane[lane]->data() : nullptr;
      for (std::size_t i = begin; i < end; ++i) {
        lanes[i * width + lane] = from != nullptr ? static_cast<T>(from[i]) : T(0);
      }
    }
  });
  context.write(buffer, lanes.get(), rows * width * sizeof(T));
}

template <class T>
void read_as(device::Context& context, const device::Buffer& buffer,
             const std::vector<std::vector<double>*>& of_lane, std::size_t width) {
  const std::size_t rows = of_lane.front()->size();
  const auto lanes = std::make_unique_for_overwrite<T[]>(rows * width);
  context.read(buffer, lanes.get(), rows * width * sizeof(T));
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
                 const std::vector<const std::vector<double>*>& of_lane, std::size_t width) {
  if (numbers.precision == Precision::single) {
    write_as<float>(context, buffer, of_lane, width);
  } else {
    write_as<double>(context, buffer, of_lane, width);
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

DevicePattern::DevicePattern(device::Context& context, const Pattern& of)
    : pattern(of), rows(static_cast<int>(pattern.rows())) {
  // Of each row the other rows that have it as a column, sorted, and in which of their slots.
  struct Other {
    int row, slot;
  };
  std::vector<std::vector<Other>> before(pattern.rows());
  const auto for_entries = [&](int i, const auto& visit) {
    const int first = pattern.start[static_cast<std::size_t>(i)];
    const int end = pattern.start[static_cast<std::size_t>(i) + 1];
    slots = std::max(slots, static_cast<std::size_t>(end - first));
    for (int k = first; k < end; ++k) visit(pattern.column[static_cast<std::size_t>(k)], k - first);
  };
  for (int i = 0; i < rows; ++i) {
    for_entries(i, [&](int j, int slot) {
      if (j != i) before[static_cast<std::size_t>(j)].push_back({i, slot});
    });
  }
  std::map<std::vector<int>, int> places;
  std::vector<int> of_row, steps, mine, last;
  for (int i = 0; i < rows; ++i) {
    mine = {0, 0};
    for (const auto [j, slot] : before[static_cast<std::size_t>(i)]) {
      mine.insert(mine.end(), {j - i, slot * rows + j - i});
    }
    for_entries(i, [&](int j, int slot) { mine.insert(mine.end(), {j - i, slot * rows}); });
    if (mine != last) {
      last = mine;
      mine[0] = static_cast<int>(mine.size() / 2) - 1;
      const auto [place, fresh] = places.try_emplace(mine, static_cast<int>(steps.size() / 2));
      if (fresh) steps.insert(steps.end(), mine.begin(), mine.end());
      of_row.push_back(place->second);
    } else {
      of_row.push_back(of_row.back());
    }
  }
  list = uploaded(context, of_row);
  step = uploaded(context, steps);
}

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
      const auto j = static_cast<Eigen::Index>(links.column[static_cast<std::size_t>(k)]);
      matrix(i, j) = matrix(j, i) = -graph.back().link[static_cast<std::size_t>(k)];
    }
  }
  const Eigen::MatrixXd inverse = matrix.llt().solve(Eigen::MatrixXd::Identity(rows, rows));
  coarsest.assign(inverse.data(), inverse.data() + inverse.size());
}

}  // namespace kappamu::forward::polygrid
