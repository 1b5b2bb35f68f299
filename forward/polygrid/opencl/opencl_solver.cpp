#include "forward/polygrid/opencl/opencl_solver.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/polygrid/opencl/device_numbers.h"
#include "forward/polygrid/opencl/former_answers.h"

namespace kappamu::forward::polygrid {

extern const device::KernelSource polygrid_cl;

namespace {

using device::Buffer;
using embedded::Lanes;

/// Of the residual that changed media leave: what little they change of the whole is solved for,
/// too.
constexpr double of_change = 0.05;

/// What has changed on the finest level.
struct Changed {
  std::vector<Stretch> rows, entries, links;
};

std::vector<Stretch> whole(const std::vector<double>& values) {
  return {{0, values.size()}};
}

/// Stretches that hold sorted `rows` and few others.
std::vector<Stretch> stretches_of(std::span<const int> rows) {
  constexpr std::size_t gap = 64;  // a write costs more than as many rows
  std::vector<Stretch> result;
  for (const int row : rows) {
    const auto at = static_cast<std::size_t>(row);
    if (result.empty() || at > result.back().end + gap) result.push_back({at, at});
    result.back().end = at + 1;
  }
  return result;
}

std::vector<Stretch> entries_of(const Pattern& pattern, std::vector<Stretch> rows) {
  for (Stretch& stretch : rows) {
    stretch = {static_cast<std::size_t>(pattern.start[stretch.begin]),
               static_cast<std::size_t>(pattern.start[stretch.end])};
  }
  return rows;
}

/// One batch on the device: its numbers, fields and work.
class BatchSolve {
 public:
  BatchSolve(device::Context& context, const Numbers& numbers, const Lanes& lanes,
             const DevicePattern& matrix, const std::vector<DeviceLevel>& levels, Lights lights)
      : context_(context),
        numbers_(numbers),
        lanes_(lanes),
        matrix_(matrix),
        levels_(levels),
        program_(context.program(polygrid_cl, numbers_.build_options(lanes))) {
    const std::size_t media = lanes.media() * numbers.real_bytes();
    const std::size_t field = lanes.width * numbers.real_bytes();
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
    partial_ = context.allocate(runs_ * lanes.width * numbers.sum_bytes());
    scalars_ = context.allocate(lanes.width * numbers.sum_bytes());
    if (lights == Lights::moving) former_.emplace(context, rows() * field);
  }

  const Lanes& lanes() const { return lanes_; }

  void set_media(const std::vector<MediumValues>& media, const std::vector<ChannelLevels>& levels,
                 const Changed& changed) {
    if (former_) former_->forget();
    const auto write = [&](const Buffer& buffer, const auto& numbers,
                           const std::vector<Stretch>& stretches) {
      std::vector<const std::vector<double>*> of_lane;
      for (const std::size_t c : lanes_.channels) of_lane.push_back(&numbers(c));
      for (const Stretch& stretch : stretches) {
        write_lanes(context_, buffer, numbers_, of_lane, lanes_.media(), stretch);
      }
    };
    const auto value = [&](std::size_t c) -> const auto& {
      return media[c].value;
    };
    write(value_, value, changed.entries);
    for (std::size_t l = 0; l < levels_.size(); ++l) {
      const auto link = [&](std::size_t c) -> const auto& {
        return levels[c].graph[l].link;
      };
      const auto inverse = [&](std::size_t c) -> const auto& {
        return levels[c].inverse_diagonal[l];
      };
      write(links_[l], link, l == 0 ? changed.links : whole(levels[0].graph[l].link));
      write(inverse_diagonal_[l], inverse,
            l == 0 ? changed.rows : whole(levels[0].inverse_diagonal[l]));
    }
    write(
        coarsest_, [&](std::size_t c) -> const auto& { return levels[c].coarsest; },
        whole(levels[0].coarsest));
  }

  void solve(const std::vector<Load>& loads, const std::vector<std::size_t>& lights,
             std::vector<std::vector<double>>& x, double tolerance, int most_iterations,
             CgReport& report) {
    const std::size_t width = lanes_.width;
    std::vector<const std::vector<double>*> powers, starts;
    std::vector<std::vector<double>*> answers;
    for (const std::size_t light : lights) {
      powers.push_back(&loads[light].power);
      starts.push_back(&x[light]);
      answers.push_back(&x[light]);
    }
    write_lanes(context_, b_, numbers_, powers, width);
    context_.zero(p_, field_bytes());
    const Buffer& r = level_r_[0];
    const bool changed = former_ && former_->size() == 0;
    if (former_ && !changed) {
      start_from_former(r);
    } else {
      write_lanes(context_, x_, numbers_, starts, width);
      over(rows(), "residual", matrix_.start, matrix_.column, value_, b_, x_, r);
    }
    const Scalars size2 = sums("dot_product", b_, b_);
    Scalars r_r = sums("dot_product", r, r), before(width, 0.0), enough(width);
    for (std::size_t lane = 0; lane < width; ++lane) {
      enough[lane] = tolerance * tolerance * size2[lane];
      if (changed) enough[lane] = std::min(enough[lane], of_change * of_change * r_r[lane]);
    }
    const auto done = [&] {
      for (std::size_t lane = 0; lane < width; ++lane) {
        if (!(r_r[lane] <= enough[lane])) return false;
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
    if (former_) keep(r);
    read_lanes(context_, x_, numbers_, answers, width);
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      double& residual = report.residual[lights[lane]];
      residual = size2[lane] > 0.0 ? std::sqrt(r_r[lane] / size2[lane]) : 0.0;
      report.converged = report.converged && residual <= tolerance;
    }
  }

 private:
  std::size_t rows() const { return static_cast<std::size_t>(matrix_.rows); }
  std::size_t field_bytes() const { return rows() * lanes_.width * numbers_.real_bytes(); }

  /// x = Σ c x_k and r = b − Σ c A x_k of the answers kept.
  void start_from_former(const Buffer& r) {
    std::vector<Scalars> times = former_->combination(b_, dot());
    context_.zero(x_, field_bytes());
    context_.copy(b_, r, field_bytes());
    for (std::size_t k = 0; k < times.size(); ++k) {
      write(times[k]);
      over(rows(), "add", scalars_, former_->answer(k), x_);
      for (double& c : times[k]) c = -c;
      write(times[k]);
      over(rows(), "add", scalars_, former_->image(k), r);
    }
  }
  /// The answer x with its image b − r.
  void keep(const Buffer& r) {
    context_.copy(b_, image_, field_bytes());
    write(Scalars(lanes_.width, -1.0));
    over(rows(), "add", scalars_, r, image_);
    former_->keep(x_, image_, dot());
  }
  FormerAnswers::Dot dot() {
    return [this](const Buffer& a, const Buffer& b) { return sums("dot_product", a, b); };
  }

  /// An item per number in [0, count).
  template <class... T>
  void over(std::size_t count, const char* kernel, const T&... arguments) {
    context_.launch(program_, kernel, {count, 1, 64, 1}, static_cast<int>(count), arguments...);
  }
  template <class... T>
  void over_step(std::size_t count, const char* kernel, const T&... arguments) {
    if (numbers_.precision == Precision::single) {
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
    return numbers_.double_sums ? read_sums<double>() : read_sums<float>();
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
    if (numbers_.double_sums) {
      context_.write(scalars_, values.data(), values.size() * sizeof(double));
    } else {
      const std::vector<float> single(values.begin(), values.end());
      context_.write(scalars_, single.data(), single.size() * sizeof(float));
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
  Numbers numbers_;
  Lanes lanes_;
  const DevicePattern& matrix_;
  const std::vector<DeviceLevel>& levels_;
  device::Program& program_;
  std::size_t runs_ = 1;
  Buffer value_, coarsest_;
  std::vector<Buffer> links_, inverse_diagonal_, level_r_, level_x_;  ///< [level]
  Buffer b_, x_, p_, image_, partial_, scalars_;
  std::optional<FormerAnswers> former_;
};

class OpenclSolver final : public LinearSolver {
 public:
  OpenclSolver(const Equations& equations, const Hierarchy& hierarchy, device::Context& context,
               Precision precision, Lights lights)
      : equations_(equations),
        hierarchy_(hierarchy),
        context_(context),
        lights_(lights),
        matrix_(context, equations.matrix()) {
    if (precision == Precision::twofold && !context.info().fp64) {
      throw InputError("device '" + context.info().name + "' has no double precision");
    }
    numbers_ = {precision, context.info().fp64, context.info().kind == device::Kind::gpu};
    const auto& levels = hierarchy.level();
    for (std::size_t l = 0; l < levels.size(); ++l) {
      levels_.emplace_back(context, levels[l],
                           l + 1 < levels.size() ? levels[l + 1].links.rows() : std::size_t{0});
    }
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
  void media_changed(std::span<const int> rows) override {
    std::vector<std::optional<ChannelLevels>> levels(media().size());
    for_rows(static_cast<int>(levels.size()), [&](int c) {
      levels[static_cast<std::size_t>(c)].emplace(hierarchy_, media()[static_cast<std::size_t>(c)]);
    });
    channels_.clear();
    for (auto& level : levels) channels_.push_back(std::move(*level));
    for (const auto& batch : batches_) batch->set_media(media(), channels_, changed(rows));
  }

  Changed changed(std::span<const int> rows) const {
    const std::vector<Stretch> stretches =
        rows.empty() ? std::vector<Stretch>{{0, equations_.unknowns()}} : stretches_of(rows);
    return {stretches, entries_of(equations_.matrix(), stretches),
            entries_of(equations_.links(), stretches)};
  }

  /// The one made before for the same lanes, or a new one.
  BatchSolve& batch_for(const Lanes& lanes) {
    for (const auto& batch : batches_) {
      if (batch->lanes().width == lanes.width && batch->lanes().channels == lanes.channels) {
        return *batch;
      }
    }
    batches_.push_back(
        std::make_unique<BatchSolve>(context_, numbers_, lanes, matrix_, levels_, lights_));
    batches_.back()->set_media(media(), channels_, changed({}));
    return *batches_.back();
  }

  const Equations& equations_;
  const Hierarchy& hierarchy_;
  device::Context& context_;
  Lights lights_;
  DevicePattern matrix_;
  Numbers numbers_;
  std::vector<DeviceLevel> levels_;
  std::vector<ChannelLevels> channels_;
  std::vector<std::unique_ptr<BatchSolve>> batches_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_opencl_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 device::Context& context, Precision precision,
                                                 Lights lights) {
  return std::make_unique<OpenclSolver>(equations, hierarchy, context, precision, lights);
}

}  // namespace kappamu::forward::polygrid
