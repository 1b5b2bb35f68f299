#include "forward/embedded/opencl/opencl_multigrid.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "core/error.h"
#include "forward/embedded/opencl/device_levels.h"

namespace kappamu::forward::embedded {

extern const device::KernelSource embedded_cl;

namespace {

using device::Buffer;
using Scalars = std::vector<double>;  ///< [lane]

/// One batch on the device.
class BatchSolve {
 public:
  /// On the levels from `first` on.
  BatchSolve(device::Context& context, const Levels& levels,
             const std::vector<LevelStructure>& structure, const Lanes& lanes, std::size_t first)
      : context_(context),
        structure_(std::span(structure).subspan(first)),
        width_(lanes.width),
        single_(context.program(embedded_cl, options("-DCYCLE=1 -DREAL=float", lanes))),
        double_(context.program(embedded_cl, options("-DCYCLE=0 -DREAL=double", lanes))) {
    for (std::size_t l = first; l < levels.level.size(); ++l) {
      numbers_.emplace_back(context, levels.level[l], lanes);
    }
    element_ = uploaded(context, packed_elements<double>(levels.level[first].elements, lanes));
    const std::size_t coarse = levels.level.back().space.unknowns(), media = lanes.media();
    std::vector<float> inverse(coarse * coarse * media, 0.0F);
    for (std::size_t m = 0; m < lanes.channels.size(); ++m) {
      const Eigen::MatrixXd& from = levels.coarsest[lanes.channels[m]];
      for (std::size_t k = 0; k < coarse * coarse; ++k) {
        inverse[k * media + m] = static_cast<float>(from.data()[k]);  // symmetric
      }
    }
    inverse_ = uploaded(context, inverse);
    const std::size_t row_bytes = width_ * sizeof(double);
    for (Buffer* field : {&r_, &x_, &p_, &image_}) *field = context.allocate(rows() * row_bytes);
    slots_ = context.allocate(static_cast<std::size_t>(structure_[0].cubes) * 8 * row_bytes);
    runs_ = std::min<std::size_t>(rows(), context.info().kind == device::Kind::gpu ? 16384 : 256);
    partial_ = context.allocate(runs_ * row_bytes);
    scalars_ = context.allocate(2 * row_bytes);
  }

  void solve(const std::vector<Load>& b, const std::vector<std::size_t>& lights,
             std::vector<std::vector<double>>& x, const CgEnd& ends, CgReport& report) {
    write_lanes(r_, lights, [&](std::size_t light) { return std::span(b[light].power); });
    write_lanes(p_, lights, [&](std::size_t light) { return std::span(x[light]); });
    over(rows(), double_, "fill", 0.0, x_);
    const Scalars b_b = sums("dot_double", r_, r_);
    product();
    write(Scalars(width_, 1.0));
    Scalars r_r = sums("update_solution", scalars_, p_, image_, x_, r_);
    Scalars r_z(width_, 0.0), r_z_before = r_z;
    over(rows(), double_, "fill", 0.0, p_);
    std::vector<bool> reached(lights.size());
    const auto done = [&] {
      for (std::size_t lane = 0; lane < lights.size(); ++lane) {
        reached[lane] =
            ends.reached(lights[lane], r_r[lane], b_b[lane], r_z[lane], r_z_before[lane]);
      }
      return std::find(reached.begin(), reached.end(), false) == reached.end();
    };
    int iteration = 0;
    for (; !done() && iteration < ends.most_iterations; ++iteration) {
      r_z_before = r_z;
      Scalars size(width_), inverse(width_), along(width_, 0.0), step(width_, 0.0);
      for (std::size_t lane = 0; lane < width_; ++lane) {
        size[lane] = r_r[lane] > 0.0 ? std::sqrt(r_r[lane]) : 1.0;
        inverse[lane] = 1.0 / size[lane];
      }
      write(inverse);
      over(rows(), double_, "to_single", scalars_, r_, numbers_[0].r);
      cycle(0);
      r_z = sums("dot_single", r_, numbers_[0].x);
      for (std::size_t lane = 0; lane < width_; ++lane) {
        r_z[lane] *= size[lane];
        if (r_z_before[lane] > 0.0) along[lane] = r_z[lane] / r_z_before[lane];
      }
      size.insert(size.end(), along.begin(), along.end());
      write(size);
      over(rows(), double_, "update_direction", scalars_, numbers_[0].x, p_);
      product();
      const Scalars p_image = sums("dot_double", p_, image_);
      for (std::size_t lane = 0; lane < width_; ++lane) {
        if (p_image[lane] > 0.0) step[lane] = r_z[lane] / p_image[lane];
      }
      write(step);
      r_r = sums("update_solution", scalars_, p_, image_, x_, r_);
    }
    balance();
    r_r = sums("dot_double", r_, r_);
    report.iterations = std::max(report.iterations, iteration);
    take(lights, x);
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      double& residual = report.residual[lights[lane]];
      residual = b_b[lane] > 0.0 ? std::sqrt(r_r[lane] / b_b[lane]) : 0.0;
      report.converged = report.converged && reached[lane];
    }
  }

 private:
  std::string options(const char* part, const Lanes& lanes) const {
    return std::string(part) + " -DWIDTH=" + std::to_string(lanes.width) +
           " -DOWN=" + (lanes.own() ? "1" : "0") +
           " -DINTERLEAVED=" + (context_.info().kind == device::Kind::gpu ? "1" : "0");
  }
  std::size_t rows() const { return static_cast<std::size_t>(structure_[0].unknowns); }

  /// An item per number in [0, count).
  template <class... T>
  void over(std::size_t count, device::Program& program, const char* kernel,
            const T&... arguments) {
    context_.launch(program, kernel, {count, 1, 64, 1}, static_cast<int>(count), arguments...);
  }
  /// Σ per lane of a kernel that leaves partial sums.
  template <class... T>
  Scalars sums(const char* kernel, const T&... arguments) {
    context_.launch(double_, kernel, {runs_, 1, 1, 1}, static_cast<int>(rows()),
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
  void write_lanes(const Buffer& to, const std::vector<std::size_t>& lights, const Field& field) {
    std::vector<double> lanes(rows() * width_, 0.0);
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      const std::span<const double> from = field(lights[lane]);
      for (std::size_t row = 0; row < from.size(); ++row) lanes[row * width_ + lane] = from[row];
    }
    context_.write(to, lanes.data(), lanes.size() * sizeof(double));
  }
  void take(const std::vector<std::size_t>& lights, std::vector<std::vector<double>>& x) {
    std::vector<double> lanes(rows() * width_);
    context_.read(x_, lanes.data(), lanes.size() * sizeof(double));
    for (std::size_t lane = 0; lane < lights.size(); ++lane) {
      std::vector<double>& mine = x[lights[lane]];
      mine.resize(rows());
      for (std::size_t row = 0; row < rows(); ++row) mine[row] = lanes[row * width_ + lane];
    }
  }

  /// image = A p.
  void product() {
    const LevelStructure& s = structure_[0];
    over(static_cast<std::size_t>(s.cubes), double_, "cube_products", s.corner, s.masters, s.place,
         element_, p_, slots_);
    over(rows(), double_, "collect", s.start, s.part, slots_, image_);
  }

  /// Adds to x the constant that makes the residual sum to zero; the residual follows.
  void balance() {
    over(rows(), double_, "fill", 1.0, p_);
    product();
    const Scalars missing = sums("dot_double", r_, p_), whole = sums("dot_double", image_, p_);
    Scalars shift(width_, 0.0);
    for (std::size_t lane = 0; lane < width_; ++lane) {
      if (whole[lane] > 0.0) shift[lane] = missing[lane] / whole[lane];
    }
    write(shift);
    sums("update_solution", scalars_, p_, image_, x_, r_);
  }

  /// Leaves A z in the level's slots.
  void level_product(std::size_t l) {
    const LevelStructure& s = structure_[l];
    const LevelNumbers& n = numbers_[l];
    over(static_cast<std::size_t>(s.cubes), single_, "cube_products", s.corner, s.masters, s.place,
         n.element, n.z, n.slots);
  }

  void smooth(std::size_t l, Start start) {
    const LevelStructure& s = structure_[l];
    const LevelNumbers& n = numbers_[l];
    const auto unknowns = static_cast<std::size_t>(s.unknowns);
    over(unknowns, single_, "smooth_first", smoothing_step(1).gain, start == Start::zero ? 1 : 0,
         n.inverse_scale, n.r, n.z, n.x);
    for (int k = 2; k <= smoothing_degree(unknowns); ++k) {
      level_product(l);
      over(unknowns, single_, "smooth_next", smoothing_step(k).keep, smoothing_step(k).gain,
           s.start, s.part, n.slots, n.inverse_scale, n.r, n.z, n.x);
    }
  }

  void subtract_product(std::size_t l) {
    const LevelStructure& s = structure_[l];
    const LevelNumbers& n = numbers_[l];
    level_product(l);
    over(static_cast<std::size_t>(s.unknowns), single_, "subtract", s.start, s.part, n.slots, n.r);
  }

  /// Turns the residual r of a level into the correction x; r is used up.
  void cycle(std::size_t l) {
    const LevelStructure& s = structure_[l];
    const LevelNumbers& n = numbers_[l];
    const auto unknowns = static_cast<std::size_t>(s.unknowns);
    if (l + 1 == structure_.size()) {
      over(unknowns, single_, "solve_directly", inverse_, n.r, n.x);
      return;
    }
    smooth(l, Start::zero);
    subtract_product(l);
    const LevelStructure& coarse = structure_[l + 1];
    const LevelNumbers& below = numbers_[l + 1];
    over(static_cast<std::size_t>(coarse.cubes), single_, "restrict_cubes", s.first_child, s.octant,
         s.owned, s.corner, n.r, below.slots);
    over(static_cast<std::size_t>(coarse.unknowns), single_, "collect", coarse.start, coarse.part,
         below.slots, below.r);
    cycle(l + 1);
    over(unknowns, single_, "prolong", s.owner, s.parent, s.octant, coarse.corner, coarse.masters,
         below.x, n.z, n.x);
    subtract_product(l);
    smooth(l, Start::given);
  }

  device::Context& context_;
  std::span<const LevelStructure> structure_;
  std::size_t width_, runs_ = 1;
  device::Program& single_;
  device::Program& double_;
  std::vector<LevelNumbers> numbers_;
  Buffer element_, inverse_;  ///< of the finest level in double; of the coarsest
  Buffer r_, x_, p_, image_, slots_, partial_, scalars_;
};

class OpenclMultigrid final : public LinearSolver {
 public:
  OpenclMultigrid(const Levels& levels, device::Context& context)
      : levels_(levels), context_(context) {
    if (!context.info().fp64) {
      throw InputError(
          "device '" + context.info().name + "' has no double precision; use another device",
          {{"device"}});
    }
    for (std::size_t l = 0; l < levels.level.size(); ++l) {
      structure_.emplace_back(
          context, levels.level[l],
          l + 1 < levels.level.size() ? levels.level[l + 1].space.cubes() : std::size_t{0});
    }
  }

  CgReport solve(const std::vector<Load>& b, std::vector<std::vector<double>>& x, const CgEnd& ends,
                 std::size_t level) override {
    CgReport report;
    report.residual.resize(b.size());
    x.resize(b.size());
    for (const Batch& batch : batches_of(b)) {
      BatchSolve(context_, levels_, structure_, batch.lanes, level)
          .solve(b, batch.lights, x, ends, report);
    }
    return report;
  }

 private:
  const Levels& levels_;
  device::Context& context_;
  std::vector<LevelStructure> structure_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_opencl_multigrid(const Levels& levels,
                                                    device::Context& context) {
  return std::make_unique<OpenclMultigrid>(levels, context);
}

}  // namespace kappamu::forward::embedded
