#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.h"
#include "forward/linear/batches.h"
#include "forward/linear/opencl/device_lanes.h"
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
class DeviceSystem : DeviceLanes {
 public:
  DeviceSystem(device::Context& context, const Numbers& numbers, const RowLevels& levels,
               const std::vector<DeviceLevel>& on_device, const Buffer& coarsest,
               const Lanes& lanes, std::size_t slice, std::size_t level)
      : DeviceLanes(context, numbers, lanes, levels.level[level].rows,
                    numbers.interleaved ? 16384 : 256, true),
        levels_(levels),
        on_device_(on_device),
        coarsest_(coarsest),
        first_(level),
        single_(program(rows_cl, "-DCYCLE=1 -DREAL=float -DSLICE=" + std::to_string(slice))),
        double_(program(rows_cl, "-DCYCLE=0 -DREAL=double -DSLICE=" + std::to_string(slice))),
        work_(levels.level.size()) {
    for (std::size_t l = level; l < work_.size(); ++l) {
      const std::size_t bytes = levels.level[l].rows * width() * sizeof(float);
      Work& w = work_[l];
      for (Buffer* field : {&w.r, &w.x, &w.z, &w.next}) *field = context.allocate(bytes);
    }
    for (Buffer* field : {&r_, &x_, &p_, &q_}) {
      *field = context.allocate(rows() * width() * sizeof(double));
    }
  }

  static constexpr bool looks_are_free = false;
  using DeviceLanes::look;

  Scalars start(const std::vector<Load>& b, const std::vector<std::vector<double>>& x,
                const std::vector<std::size_t>& lights) {
    std::vector<const std::vector<double>*> powers, starts;
    for (const std::size_t light : lights) {
      powers.push_back(&b[light].power);
      starts.push_back(&x[light]);
    }
    write_lanes(r_, powers, rows(), width());
    write_lanes(p_, starts, rows(), width());
    over(double_, rows(), "fill", 0.0, x_);
    const Scalars b_b = dot(r_, r_);
    begin();
    multiply();
    advance_by(Scalars(width(), 1.0));
    over(double_, rows(), "fill", 0.0, p_);
    return b_b;
  }
  void precondition() {
    over(double_, rows(), "to_single", scalars(), r_, work_[first_].r);
    v_cycle(*this, levels_, first_);
    sum_to(Place::r_z, double_, "dot_single", r_, work_[first_].x);
  }
  void direct() {
    over(double_, rows(), "update_direction", scalars(), work_[first_].x, p_);
    multiply();
    sum_to(Place::step, double_, "dot_double", p_, q_);
  }
  void advance() {
    sum_to(Place::size, double_, "update_solution", static_cast<int>(Place::step), scalars(), p_,
           q_, x_, r_);
  }
  Scalars add_constant() {
    over(double_, rows(), "fill", 1.0, p_);
    multiply();
    const Scalars missing = dot(r_, p_);
    advance_by(quotients(missing, dot(q_, p_)));
    return look().size;
  }
  void take(std::vector<std::vector<double>>& x, const std::vector<std::size_t>& lights) {
    std::vector<std::vector<double>*> answers;
    for (const std::size_t light : lights) answers.push_back(&x[light]);
    read_lanes(x_, answers);
  }

  void smooth_first(std::size_t l, Start start) {
    over(single_, levels_.level[l].rows, "smooth_first", smoothing_step(1).gain,
         start == Start::zero ? 1 : 0, on_device_[l].inverse_scale, work_[l].r, work_[l].z,
         work_[l].x);
  }
  void smooth_next(std::size_t l, int k) {
    const auto& [pattern, value] = on_device_[l].matrix;
    Work& w = work_[l];
    over(single_, levels_.level[l].rows, "smooth_next", smoothing_step(k).keep,
         smoothing_step(k).gain, pattern.start, pattern.column, value, on_device_[l].inverse_scale,
         w.r, w.z, w.next, w.x);
    std::swap(w.z, w.next);
  }
  void subtract_product(std::size_t l) {
    times(l, "subtract_product", on_device_[l].matrix, work_[l].z, work_[l].r);
  }
  void restrict_to(std::size_t l) {
    times(l, "restrict_to", on_device_[l - 1].restriction, work_[l - 1].r, work_[l].r);
  }
  void prolong_to(std::size_t l) {
    times(l, "prolong_to", on_device_[l].interpolation, work_[l + 1].x, work_[l].z, work_[l].x);
  }
  void solve_directly(std::size_t l) {
    over(single_, levels_.level[l].rows, "solve_directly", coarsest_, work_[l].r, work_[l].x);
  }

 private:
  struct Work {
    Buffer r, x, z, next;  ///< residual, correction, step, next step
  };

  template <class... T>
  void times(std::size_t l, const char* kernel, const DeviceMatrix& matrix, const T&... fields) {
    over(single_, levels_.level[l].rows, kernel, matrix.pattern.start, matrix.pattern.column,
         matrix.value, fields...);
  }
  /// q = A p.
  void multiply() {
    const auto& [pattern, value] = on_device_[first_].equations;
    over(double_, rows(), "product", pattern.start, pattern.column, value, p_, q_);
  }
  Scalars dot(const Buffer& a, const Buffer& b) { return sums(double_, 1, "dot_double", a, b)[0]; }
  /// advance() by what the host says.
  void advance_by(const Scalars& step) {
    write({step});
    sum_to(Place::size, double_, "update_solution", 0, given(), p_, q_, x_, r_);
  }

  const RowLevels& levels_;
  const std::vector<DeviceLevel>& on_device_;
  const Buffer& coarsest_;
  std::size_t first_;
  device::Program& single_;
  device::Program& double_;
  std::vector<Work> work_;  ///< [level]
  Buffer r_, x_, p_, q_;
};

class OpenclSolver final : public BatchSolver {
 public:
  OpenclSolver(Assembly assembly, device::Context& context, std::optional<std::size_t> slice)
      : BatchSolver(std::move(assembly)),
        context_(context),
        slice_(slice.value_or(context.info().kind == device::Kind::gpu ? gpu_slice : 1)),
        numbers_{Precision::twofold, true, slice_ > 1} {
    if (!context.info().fp64) {
      throw InputError(
          "device '" + context.info().name + "' has no double precision; use another device",
          {{"device"}});
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
    DeviceSystem system(context_, numbers_, levels(), on_device_, coarsest_, batch.lanes, slice_,
                        level);
    solve_batch(system, b, batch.lights, x, ends, report);
  }

  device::Context& context_;
  std::size_t slice_;
  Numbers numbers_;
  std::vector<DeviceLevel> on_device_;
  Buffer coarsest_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_opencl_solver(Assembly assembly, device::Context& context,
                                                 std::optional<std::size_t> slice) {
  return std::make_unique<OpenclSolver>(std::move(assembly), context, slice);
}

}  // namespace kappamu::forward::linear
