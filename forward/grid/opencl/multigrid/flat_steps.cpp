#include <optional>

#include "forward/grid/opencl/multigrid/cg_steps.h"
#include "forward/grid/opencl/multigrid/flat_cycle.h"

namespace kappamu::forward {

namespace {

class FlatSteps final : public CgSteps {
 public:
  FlatSteps(device::Context& context, const Format& format, const Hierarchy& hierarchy, int lanes);

  void begin(InitialGuess guess) override;
  Norms true_residual(const LaneKernels& kernels, const device::Buffer& b,
                      const device::Buffer& x) override;
  LaneScalars step(const LaneKernels& kernels) override;
  void restart() override { fresh_ = true; }

 private:
  /// Launches a kernel that leaves partial sums, `sum` being their total.
  template <class... T>
  void launch_sum(const LaneKernels& kernels, device::Program& program, const char* kernel,
                  const device::Buffer& sum, const T&... arguments) {
    const GridShape& s = hierarchy_.finest().shape;
    context_.launch(program, kernel, kernels.summed(s), s.nx, s.ny, s.nz, arguments..., partial_);
    sums_.add_up(kernels, partial_, kernels.partials(s), sum);
  }

  device::Context& context_;
  const Hierarchy& hierarchy_;
  std::optional<FlatCycle> cycle_;  ///< takes its fields after those of the finest level
  LaneSums sums_;
  std::size_t reds_;    ///< places of one colour
  std::size_t vector_;  ///< [bytes]
  /// By colour (grid_flat_prelude.cl), r of red cells only; the black places of z, p and S p are
  /// scratch, those of the red cells of S p while z is found.
  device::Buffer r_, d_, z_, p_, image_, partial_;
  device::Buffer rz_[2], energy_, rr_, bb_;
  LaneScalars norm_b_;
  std::size_t now_ = 0;
  bool fresh_ = true;    ///< no direction yet
  bool first_d_ = true;  ///< d is zero, whatever its buffer holds
  bool zero_ = false;    ///< φ + d is
};

FlatSteps::FlatSteps(device::Context& context, const Format& format, const Hierarchy& hierarchy,
                     int lanes)
    : context_(context),
      hierarchy_(hierarchy),
      sums_(context, format),
      reds_(half_cells(hierarchy.finest().shape)),
      vector_(static_cast<std::size_t>(lanes) * format.real_bytes()) {
  Workspace& work = hierarchy.workspace();
  work.begin(reds_ * vector_);
  for (device::Buffer* field : {&d_, &z_, &p_, &image_}) *field = work.take(2 * reds_ * vector_);
  // A right-hand side of the last level, which a single cell is, has black places too.
  r_ = work.take((hierarchy.levels().size() > 1 ? reds_ : 2 * reds_) * vector_);
  cycle_.emplace(context, format, hierarchy, lanes);
  const std::size_t scalars = static_cast<std::size_t>(lanes) * format.accu_bytes();
  partial_ = context.allocate(LaneKernels::most_partials * scalars);
  for (device::Buffer* scalar : {&rz_[0], &rz_[1], &energy_, &rr_, &bb_}) {
    *scalar = context.allocate(scalars);
  }
}

void FlatSteps::begin(InitialGuess guess) {
  fresh_ = first_d_ = true;
  zero_ = guess == InitialGuess::zero;
  norm_b_.clear();
}

CgSteps::Norms FlatSteps::true_residual(const LaneKernels& kernels, const device::Buffer& b,
                                        const device::Buffer& x) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  const device::Range items = kernels.tiled(s);
  if (norm_b_.empty()) {
    launch_sum(kernels, kernels.residual(), "squares", bb_, b);
    norm_b_ = sums_.read(kernels, bb_);
  }
  if (zero_) {
    launch_sum(kernels, kernels.residual(), "residual_of_zero", rr_, level.stencils, level.smoother,
               b, x, r_);
    return {sums_.read(kernels, rr_), norm_b_};
  }
  if (!first_d_) {
    context_.launch(kernels.residual(), "renormalise", items, s.nx, s.ny, s.nz, level.stencils, x,
                    d_);
  }
  context_.launch(kernels.residual(), "solve_black_accurately", items, s.nx, s.ny, s.nz,
                  level.stencils, int{!first_d_}, b, x, d_);
  launch_sum(kernels, kernels.residual(), "true_residual", rr_, level.stencils, int{!first_d_}, b,
             x, d_, r_);
  return {sums_.read(kernels, rr_), norm_b_};
}

LaneScalars FlatSteps::step(const LaneKernels& kernels) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  const device::Buffer &rz = rz_[now_], &rz_before = rz_[1 - now_];
  cycle_->precondition(kernels, r_, z_, image_, partial_);
  sums_.add_up(kernels, partial_, kernels.partials(s), rz);
  context_.launch(kernels.steps(), "next_direction", kernels.flat(reds_), static_cast<int>(reds_),
                  int{fresh_}, rz, rz_before, z_, p_);
  context_.launch(kernels.steps(), "solve_black_of_direction", kernels.tiled(s), s.nx, s.ny, s.nz,
                  level.stencils, p_, image_);
  launch_sum(kernels, kernels.steps(), "image_of_direction", energy_, level.stencils, p_, image_);
  launch_sum(kernels, kernels.steps(), "update", rr_, int{first_d_}, rz, energy_, p_, image_, d_,
             r_);
  now_ = 1 - now_;
  fresh_ = first_d_ = zero_ = false;
  return sums_.read(kernels, rr_);
}

}  // namespace

std::unique_ptr<CgSteps> make_flat_steps(device::Context& context, const Format& format,
                                         const Hierarchy& hierarchy, int lanes) {
  return std::make_unique<FlatSteps>(context, format, hierarchy, lanes);
}

}  // namespace kappamu::forward
