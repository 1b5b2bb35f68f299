#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.h"
#include "forward/linear/batches.h"
#include "forward/linear/conjugate_gradients.h"
#include "forward/linear/opencl/device_rows.h"

namespace kappamu::forward::linear {

extern const device::KernelSource rows_cl;

namespace {

using device::Buffer;

/// Rows of a slice on GPUs: what runs in step.
constexpr std::size_t gpu_slice = 32;

struct DeviceMatrix {
  DevicePattern pattern;
  Buffer value;
};

/// A level in the device's memory; what the host's has is given up.
struct DeviceLevel {
  DeviceMatrix equations, matrix, interpolation, restriction;
  Buffer inverse_scale;

  DeviceLevel(device::Context& context, RowLevel& level, std::size_t slice) {
    const auto moved = [&](auto& from, const DevicePattern* shared = nullptr) {
      DeviceMatrix to;
      if (!from.pattern) return to;
      to.pattern = shared != nullptr ? *shared : DevicePattern(context, *from.pattern, slice);
      to.value = uploaded_values(context, *from.pattern, from.value, slice);
      return to;
    };
    matrix = moved(level.matrix);
    equations = moved(level.equations,
                      level.equations.pattern == level.matrix.pattern ? &matrix.pattern : nullptr);
    interpolation = moved(level.interpolation);
    restriction = moved(level.restriction);
    inverse_scale = uploaded(context, level.inverse_scale);
    level.matrix = level.interpolation = level.restriction = {};
    level.equations = {};
    level.inverse_scale = {};
  }
};

/// Fields of a batch; what solve_batch() and v_cycle() ask for.
class DeviceSystem {
 public:
  DeviceSystem(device::Context& context, const RowLevels& levels,
               const std::vector<DeviceLevel>& on_device, const Buffer& coarsest,
               const Lanes& lanes, std::size_t slice, std::size_t level)
      : context_(context),
        levels_(levels),
        on_device_(on_device),
        coarsest_(coarsest),
        first_(level),
        rows_(levels.level[level].rows),
        width_(lanes.width),
        single_(context.program(rows_cl, options("-DCYCLE=1 -DREAL=float", lanes, slice))),
        double_(context.program(rows_cl, options("-DCYCLE=0 -DREAL=double", lanes, slice))),
        work_(levels.level.size()) {
    for (std::size_t l = level; l < work_.size(); ++l) {
      const std::size_t bytes = levels.level[l].rows * width_ * sizeof(float);
      Work& w = work_[l];
      for (Buffer* field : {&w.r, &w.x, &w.z, &w.next}) *field = context.allocate(bytes);
    }
    const std::size_t row_bytes = width_ * sizeof(double);
    for (Buffer* field : {&r_, &x_, &p_, &q_}) *field = context.allocate(rows_ * row_bytes);
    runs_ = std::min<std::size_t>(rows_, context.info().kind == device::Kind::gpu ? 16384 : 256);
    partial_ = context.allocate(runs_ * row_bytes);
    scalars_ = context.allocate(2 * row_bytes);
  }

  std::pair<Scalars, Scalars> start(const std::vector<Load>& b,
                                    const std::vector<std::vector<double>>& x,
                                    const std::vector<std::size_t>& lights) {
    put(r_, lights, [&](std::size_t light) { return std::span(b[light].power); });
    put(p_, lights, [&](std::size_t light) { return std::span(x[light]); });
    over(rows_, double_, "fill", 0.0, x_);
    const Scalars b_b = sums("dot_double", r_, r_);
    multiply();
    const Scalars r_r = advance(Scalars(width_, 1.0));
    over(rows_, double_, "fill", 0.0, p_);
    return {b_b, r_r};
  }
  Scalars precondition(const Scalars& r_r) {
    size_.resize(width_);
    Scalars inverse(width_);
    for (std::size_t lane = 0; lane < width_; ++lane) {
      size_[lane] = r_r[lane] > 0.0 ? std::sqrt(r_r[lane]) : 1.0;
      inverse[lane] = 1.0 / size_[lane];
    }
    write(inverse);
    over(rows_, double_, "to_single", scalars_, r_, work_[first_].r);
    v_cycle(*this, levels_, first_);
    Scalars r_z = sums("dot_single", r_, work_[first_].x);
    for (std::size_t lane = 0; lane < width_; ++lane) r_z[lane] *= size_[lane];
    return r_z;
  }
  Scalars direct(const Scalars& along) {
    Scalars both = size_;
    both.insert(both.end(), along.begin(), along.end());
    write(both);
    over(rows_, double_, "update_direction", scalars_, work_[first_].x, p_);
    multiply();
    return sums("dot_double", p_, q_);
  }
  std::pair<Scalars, Scalars> direct_to_ones() {
    over(rows_, double_, "fill", 1.0, p_);
    multiply();
    return {sums("dot_double", r_, p_), sums("dot_double", q_, p_)};
  }
  Scalars advance(const Scalars& step) {
    write(step);
    return sums("update_solution", scalars_, p_, q_, x_, r_);
  }
  void take(std::vector<std::vector<double>>& x, const std::vector<std::size_t>& lights) {
    std::vector<double> lanes(rows_ * width_);
    context_.read(x_, lanes.data(), lanes.size() * sizeof(double));
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      std::vector<double>& mine = x[lights[lane]];
      mine.resize(rows_);
      for (std::size_t row = 0; row < rows_; ++row) mine[row] = lanes[row * width_ + lane];
    }
  }

  void smooth_first(std::size_t l, Start start) {
    over(levels_.level[l].rows, single_, "smooth_first", smoothing_step(1).gain,
         start == Start::zero ? 1 : 0, on_device_[l].inverse_scale, work_[l].r, work_[l].z,
         work_[l].x);
  }
  void smooth_next(std::size_t l, int k) {
    const auto& [pattern, value] = on_device_[l].matrix;
    Work& w = work_[l];
    over(levels_.level[l].rows, single_, "smooth_next", smoothing_step(k).keep,
         smoothing_step(k).gain, pattern.start, pattern.column, value, on_device_[l].inverse_scale,
         w.r, w.z, w.next, w.x);
    std::swap(w.z, w.next);
  }
  void subtract_product(std::size_t l) {
    rows_times(l, "subtract_product", on_device_[l].matrix, work_[l].z, work_[l].r);
  }
  void restrict_to(std::size_t l) {
    rows_times(l, "restrict_to", on_device_[l - 1].restriction, work_[l - 1].r, work_[l].r);
  }
  void prolong_to(std::size_t l) {
    rows_times(l, "prolong_to", on_device_[l].interpolation, work_[l + 1].x, work_[l].z,
               work_[l].x);
  }
  void solve_directly(std::size_t l) {
    over(levels_.level[l].rows, single_, "solve_directly", coarsest_, work_[l].r, work_[l].x);
  }

 private:
  struct Work {
    Buffer r, x, z, next;  ///< residual, correction, step, next step
  };

  std::string options(const char* part, const Lanes& lanes, std::size_t slice) const {
    return std::string(part) + " -DWIDTH=" + std::to_string(lanes.width) +
           " -DOWN=" + (lanes.own() ? "1" : "0") +
           " -DINTERLEAVED=" + (context_.info().kind == device::Kind::gpu ? "1" : "0") +
           " -DSLICE=" + std::to_string(slice);
  }

  /// An item per number in [0, count).
  template <class... T>
  void over(std::size_t count, device::Program& program, const char* kernel,
            const T&... arguments) {
    context_.launch(program, kernel, {count, 1, 64, 1}, static_cast<int>(count), arguments...);
  }
  template <class... T>
  void rows_times(std::size_t l, const char* kernel, const DeviceMatrix& matrix,
                  const T&... fields) {
    over(levels_.level[l].rows, single_, kernel, matrix.pattern.start, matrix.pattern.column,
         matrix.value, fields...);
  }
  /// q = A p.
  void multiply() {
    const auto& [pattern, value] = on_device_[first_].equations;
    over(rows_, double_, "product", pattern.start, pattern.column, value, p_, q_);
  }
  /// Σ per lane of a kernel that leaves partial sums.
  template <class... T>
  Scalars sums(const char* kernel, const T&... arguments) {
    context_.launch(double_, kernel, {runs_, 1, 1, 1}, static_cast<int>(rows_),
                    static_cast<int>(runs_), arguments..., partial_);
    Scalars parts(runs_ * width_), total(width_, 0.0);
    context_.read(partial_, parts.data(), parts.size() * sizeof(double));
    for (std::size_t k = 0; k < parts.size(); ++k) total[k % width_] += parts[k];
    return total;
  }
  void write(const Scalars& values) {
    context_.write(scalars_, values.data(), values.size() * sizeof(double));
  }
  /// A field of each light, zero where it is empty.
  template <class Field>
  void put(const Buffer& to, const std::vector<std::size_t>& lights, const Field& field) {
    std::vector<double> lanes(rows_ * width_, 0.0);
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      const std::span<const double> from = field(lights[lane]);
      for (std::size_t row = 0; row < from.size(); ++row) lanes[row * width_ + lane] = from[row];
    }
    context_.write(to, lanes.data(), lanes.size() * sizeof(double));
  }

  device::Context& context_;
  const RowLevels& levels_;
  const std::vector<DeviceLevel>& on_device_;
  const Buffer& coarsest_;
  std::size_t first_, rows_, width_, runs_ = 1;
  device::Program& single_;
  device::Program& double_;
  std::vector<Work> work_;  ///< [level]
  Buffer r_, x_, p_, q_, partial_, scalars_;
  Scalars size_;  ///< the residual's length
};

class OpenclSolver final : public BatchSolver {
 public:
  OpenclSolver(Assembly assembly, device::Context& context)
      : BatchSolver(std::move(assembly)),
        context_(context),
        slice_(context.info().kind == device::Kind::gpu ? gpu_slice : 1) {
    if (!context.info().fp64) {
      throw InputError("device '" + context.info().name +
                       "' has no double precision; use another --device");
    }
  }

 private:
  void assembled(RowLevels& levels) override {
    on_device_.clear();
    for (RowLevel& level : levels.level) on_device_.emplace_back(context_, level, slice_);
    coarsest_ = uploaded(context_, levels.coarsest);
  }
  void solve_batch_on(std::size_t level, const std::vector<Load>& b, const Batch& batch,
                      std::vector<std::vector<double>>& x, const CgEnd& ends,
                      CgReport& report) override {
    DeviceSystem system(context_, levels(), on_device_, coarsest_, batch.lanes, slice_, level);
    solve_batch(system, b, batch.lights, x, ends, report);
  }

  device::Context& context_;
  std::size_t slice_;
  std::vector<DeviceLevel> on_device_;
  Buffer coarsest_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_opencl_solver(Assembly assembly, device::Context& context) {
  return std::make_unique<OpenclSolver>(std::move(assembly), context);
}

}  // namespace kappamu::forward::linear
