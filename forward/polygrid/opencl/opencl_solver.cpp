#include "forward/polygrid/opencl/opencl_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "forward/embedded/equations/row_ranges.h"
#include "forward/embedded/opencl/device_levels.h"

namespace kappamu::forward::polygrid {

extern const device::KernelSource polygrid_cl;

namespace {

using device::Buffer;
using embedded::Lanes;
using embedded::uploaded;
using Scalars = std::vector<double>;  ///< [lane]

struct Options {
  Precision precision = Precision::single;
  bool double_sums = true, interleaved = false;
  std::size_t real_bytes() const { return precision == Precision::single ? 4 : 8; }
  std::size_t sum_bytes() const { return double_sums ? 8 : 4; }
};

/// `values` of lanes beside each other, [row][lane], as a device's numbers; lanes without are zero.
template <class T>
std::vector<T> interleaved(const std::vector<const std::vector<double>*>& of_lane,
                           std::size_t width) {
  const std::size_t rows = of_lane.front()->size();
  std::vector<T> result(rows * width, T(0));
  embedded::for_row_ranges(rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t lane = 0; lane < of_lane.size(); ++lane) {
      const double* from = of_lane[lane]->data();
      for (std::size_t i = begin; i < end; ++i) {
        result[i * width + lane] = static_cast<T>(from[i]);
      }
    }
  });
  return result;
}

void write_lanes(device::Context& context, const Buffer& buffer, const Options& options,
                 const std::vector<const std::vector<double>*>& of_lane, std::size_t width) {
  if (options.precision == Precision::single) {
    const auto lanes = interleaved<float>(of_lane, width);
    context.write(buffer, lanes.data(), lanes.size() * sizeof(float));
  } else {
    const auto lanes = interleaved<double>(of_lane, width);
    context.write(buffer, lanes.data(), lanes.size() * sizeof(double));
  }
}

/// Places of a pattern in the device's memory.
struct DevicePattern {
  int rows = 0;
  std::size_t entries = 0;
  Buffer start, column;
  DevicePattern(device::Context& context, const Pattern& pattern)
      : rows(static_cast<int>(pattern.rows())),
        entries(pattern.column.size()),
        start(uploaded(context, pattern.start)),
        column(uploaded(context, pattern.column)) {}
};

struct DeviceLevel {
  DevicePattern links;
  Buffer parent, first_child, child;  ///< none on the coarsest

  DeviceLevel(device::Context& context, const GraphLevel& level, std::size_t coarser)
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
    parent = uploaded(context, level.parent);
    first_child = uploaded(context, first);
    child = uploaded(context, children);
  }
};

/// One channel's numbers on the host.
struct Channel {
  MediumValues medium;
  std::vector<GraphValues> graph;
  std::vector<std::vector<double>> inverse_diagonal;  ///< [level]
  std::vector<double> coarsest;                       ///< inverse of the coarsest level's matrix

  Channel(const Hierarchy& hierarchy, const MediumValues& values)
      : medium(values), graph(hierarchy.values(values)) {
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
};

/// One batch on the device: its numbers, fields and work.
class BatchSolve {
 public:
  BatchSolve(device::Context& context, const Options& options, const Lanes& lanes,
             const DevicePattern& matrix, const std::vector<DeviceLevel>& levels)
      : context_(context),
        options_(options),
        lanes_(lanes),
        matrix_(matrix),
        levels_(levels),
        program_(context.program(polygrid_cl, build_options())) {
    const std::size_t media = lanes.media() * options.real_bytes();
    const std::size_t field = lanes.width * options.real_bytes();
    value_ = context.allocate(matrix.entries * media);
    for (const DeviceLevel& level : levels) {
      const auto rows = static_cast<std::size_t>(level.links.rows);
      links_.push_back(context.allocate(std::max<std::size_t>(level.links.entries, 1) * media));
      inverse_diagonal_.push_back(context.allocate(rows * media));
      level_r_.push_back(context.allocate(rows * field));
      level_x_.push_back(context.allocate(rows * field));
    }
    const auto coarsest = static_cast<std::size_t>(levels.back().links.rows);
    coarsest_ = context.allocate(coarsest * coarsest * media);
    for (Buffer* each : {&b_, &x_, &p_, &image_}) *each = context.allocate(rows() * field);
    runs_ = std::min<std::size_t>(rows(), context.info().kind == device::Kind::gpu ? 4096 : 64);
    partial_ = context.allocate(runs_ * lanes.width * options.sum_bytes());
    scalars_ = context.allocate(lanes.width * options.sum_bytes());
  }

  const Lanes& lanes() const { return lanes_; }

  void set_media(const std::vector<Channel>& channels) {
    const auto write = [&](const Buffer& buffer, const auto& numbers) {
      std::vector<const std::vector<double>*> of_lane;
      for (const std::size_t c : lanes_.channels) of_lane.push_back(&numbers(channels[c]));
      if (!of_lane.front()->empty()) {
        write_lanes(context_, buffer, options_, of_lane, lanes_.media());
      }
    };
    write(
        value_, [](const Channel& c) -> const auto& { return c.medium.value; });
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      write(
          links_[l], [l](const Channel& c) -> const auto& { return c.graph[l].link; });
      write(
          inverse_diagonal_[l], [l](const Channel& c) -> const auto& {
            return c.inverse_diagonal[l];
          });
    }
    write(
        coarsest_, [](const Channel& c) -> const auto& { return c.coarsest; });
  }

  void solve(const std::vector<Load>& loads, const std::vector<std::size_t>& lights,
             std::vector<std::vector<double>>& x, double tolerance, int most_iterations,
             CgReport& report) {
    const std::size_t width = lanes_.width;
    std::vector<const std::vector<double>*> powers, starts;
    for (const std::size_t light : lights) {
      powers.push_back(&loads[light].power);
      starts.push_back(&x[light]);
    }
    write_lanes(context_, b_, options_, powers, width);
    write_lanes(context_, x_, options_, starts, width);
    context_.zero(p_, rows() * width * options_.real_bytes());
    const Buffer& r = level_r_[0];
    over(rows(), "residual", matrix_.start, matrix_.column, value_, b_, x_, r);
    const Scalars size2 = sums("dot_product", b_, b_);
    Scalars r_r = sums("dot_product", r, r), before(width, 0.0);
    const auto done = [&] {
      for (std::size_t lane = 0; lane < width; ++lane) {
        if (!(r_r[lane] <= tolerance * tolerance * size2[lane])) return false;
      }
      return true;
    };
    int iteration = 0;
    for (; iteration < most_iterations && !done(); ++iteration) {
      cycle(0);
      const Scalars r_z = sums("dot_product", r, level_x_[0]);
      Scalars along(width, 0.0), step(width, 0.0);
      for (std::size_t lane = 0; lane < width; ++lane) {
        if (before[lane] > 0.0) along[lane] = r_z[lane] / before[lane];
      }
      write(along);
      over(rows(), "update_direction", scalars_, level_x_[0], p_);
      over(rows(), "product", matrix_.start, matrix_.column, value_, p_, image_);
      const Scalars p_image = sums("dot_product", p_, image_);
      for (std::size_t lane = 0; lane < width; ++lane) {
        if (p_image[lane] > 0.0) step[lane] = r_z[lane] / p_image[lane];
      }
      write(step);
      r_r = sums("update_solution", scalars_, p_, image_, x_, r);
      before = r_z;
    }
    report.iterations = std::max(report.iterations, iteration);
    take(lights, x);
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      double& residual = report.residual[lights[lane]];
      residual = size2[lane] > 0.0 ? std::sqrt(r_r[lane] / size2[lane]) : 0.0;
      report.converged = report.converged && residual <= tolerance;
    }
  }

 private:
  std::size_t rows() const { return static_cast<std::size_t>(matrix_.rows); }
  std::string build_options() const {
    return std::string("-DREAL=") + (options_.precision == Precision::single ? "float" : "double") +
           " -DSUM=" + (options_.double_sums ? "double" : "float") +
           " -DWIDTH=" + std::to_string(lanes_.width) + " -DOWN=" + (lanes_.own() ? "1" : "0") +
           " -DINTERLEAVED=" + (options_.interleaved ? "1" : "0");
  }

  /// An item per number in [0, count).
  template <class... T>
  void over(std::size_t count, const char* kernel, const T&... arguments) {
    context_.launch(program_, kernel, {count, 1, 64, 1}, static_cast<int>(count), arguments...);
  }
  template <class... T>
  void over_step(std::size_t count, const char* kernel, const T&... arguments) {
    if (options_.precision == Precision::single) {
      over(count, kernel, static_cast<float>(jacobi_step), arguments...);
    } else {
      over(count, kernel, jacobi_step, arguments...);
    }
  }

  /// Σ per lane of a kernel that leaves partial sums.
  template <class... T>
  Scalars sums(const char* kernel, const T&... arguments) {
    context_.launch(program_, kernel, {runs_, 1, 1, 1}, static_cast<int>(rows()),
                    static_cast<int>(runs_), arguments..., partial_);
    return options_.double_sums ? read_sums<double>() : read_sums<float>();
  }
  template <class T>
  Scalars read_sums() {
    std::vector<T> parts(runs_ * lanes_.width);
    context_.read(partial_, parts.data(), parts.size() * sizeof(T));
    Scalars total(lanes_.width, 0.0);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      total[k % lanes_.width] += static_cast<double>(parts[k]);
    }
    return total;
  }
  void write(const Scalars& values) {
    if (options_.double_sums) {
      context_.write(scalars_, values.data(), values.size() * sizeof(double));
    } else {
      const std::vector<float> single(values.begin(), values.end());
      context_.write(scalars_, single.data(), single.size() * sizeof(float));
    }
  }

  void take(const std::vector<std::size_t>& lights, std::vector<std::vector<double>>& x) {
    if (options_.precision == Precision::single) {
      take_as<float>(lights, x);
    } else {
      take_as<double>(lights, x);
    }
  }
  template <class T>
  void take_as(const std::vector<std::size_t>& lights, std::vector<std::vector<double>>& x) {
    std::vector<T> lanes(rows() * lanes_.width);
    context_.read(x_, lanes.data(), lanes.size() * sizeof(T));
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      std::vector<double>& mine = x[lights[lane]];
      for (std::size_t row = 0; row < rows(); ++row) {
        mine[row] = static_cast<double>(lanes[row * lanes_.width + lane]);
      }
    }
  }

  /// From the residual of a level to its correction.
  void cycle(std::size_t l) {
    const DeviceLevel& level = levels_[l];
    const auto count = static_cast<std::size_t>(level.links.rows);
    if (l + 1 == levels_.size()) {
      over(count, "solve_directly", coarsest_, level_r_[l], level_x_[l]);
      return;
    }
    over_step(static_cast<std::size_t>(levels_[l + 1].links.rows), "down", level.first_child,
              level.child, level.links.start, level.links.column, links_[l], inverse_diagonal_[l],
              level_r_[l], level_r_[l + 1]);
    cycle(l + 1);
    over_step(count, "up", level.parent, level.links.start, level.links.column, links_[l],
              inverse_diagonal_[l], level_r_[l], level_x_[l + 1], level_x_[l]);
  }

  device::Context& context_;
  Options options_;
  Lanes lanes_;
  const DevicePattern& matrix_;
  const std::vector<DeviceLevel>& levels_;
  device::Program& program_;
  std::size_t runs_ = 1;
  Buffer value_, coarsest_;
  std::vector<Buffer> links_, inverse_diagonal_, level_r_, level_x_;  ///< [level]
  Buffer b_, x_, p_, image_, partial_, scalars_;
};

class OpenclSolver final : public LinearSolver {
 public:
  OpenclSolver(const Equations& equations, const Hierarchy& hierarchy, device::Context& context,
               Precision precision)
      : hierarchy_(hierarchy), context_(context), matrix_(context, equations.matrix()) {
    if (precision == Precision::twofold && !context.info().fp64) {
      throw InputError("device '" + context.info().name + "' has no double precision");
    }
    options_ = {precision, context.info().fp64, context.info().kind == device::Kind::gpu};
    const auto& levels = hierarchy.level();
    for (std::size_t l = 0; l < levels.size(); ++l) {
      levels_.emplace_back(context, levels[l],
                           l + 1 < levels.size() ? levels[l + 1].links.rows() : std::size_t{0});
    }
  }

  void set_media(const std::vector<MediumValues>& media) override {
    channels_.clear();
    for (const MediumValues& medium : media) channels_.emplace_back(hierarchy_, medium);
    for (const auto& batch : batches_) batch->set_media(channels_);
  }

  CgReport solve(const std::vector<Load>& loads, std::vector<std::vector<double>>& x,
                 double tolerance, int most_iterations) override {
    CgReport report;
    report.residual.resize(loads.size());
    x.resize(loads.size());
    for (auto& start : x) start.resize(static_cast<std::size_t>(matrix_.rows), 0.0);
    for (const embedded::Batch& batch : embedded::batches_of(loads)) {
      batch_for(batch.lanes).solve(loads, batch.lights, x, tolerance, most_iterations, report);
    }
    return report;
  }

 private:
  /// The one made before for the same lanes, or a new one.
  BatchSolve& batch_for(const Lanes& lanes) {
    for (const auto& batch : batches_) {
      if (batch->lanes().width == lanes.width && batch->lanes().channels == lanes.channels) {
        return *batch;
      }
    }
    batches_.push_back(std::make_unique<BatchSolve>(context_, options_, lanes, matrix_, levels_));
    batches_.back()->set_media(channels_);
    return *batches_.back();
  }

  const Hierarchy& hierarchy_;
  device::Context& context_;
  DevicePattern matrix_;
  Options options_;
  std::vector<DeviceLevel> levels_;
  std::vector<Channel> channels_;
  std::vector<std::unique_ptr<BatchSolve>> batches_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_opencl_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 device::Context& context, Precision precision) {
  return std::make_unique<OpenclSolver>(equations, hierarchy, context, precision);
}

}  // namespace kappamu::forward::polygrid
