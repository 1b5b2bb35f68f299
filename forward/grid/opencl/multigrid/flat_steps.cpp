#include <algorithm>

#include "forward/grid/opencl/multigrid/cg_steps.h"
#include "forward/grid/opencl/multigrid/multigrid.h"

namespace kappamu::forward {

namespace {

class FlatSteps final : public CgSteps {
 public:
  FlatSteps(device::Context& context, const Format& format, const Hierarchy& hierarchy, int lanes)
      : context_(context),
        hierarchy_(hierarchy),
        multigrid_(context, format, hierarchy, lanes),
        sums_(context, format, lanes),
        cells_(hierarchy.finest().shape.cells()),
        real_bytes_(format.real_bytes()) {
    const auto l = static_cast<std::size_t>(lanes);
    for (device::Buffer* field : {&r_, &d_, &z_, &p_, &q_})
      *field = context.allocate(cells_ * l * real_bytes_);
    const std::size_t sums = std::max(row_sums(hierarchy.finest().shape, Layout::gpu),
                                      static_cast<std::size_t>(run_count(cells_, Layout::gpu)));
    for (device::Buffer* partial : {&partial_, &partial_bb_}) {
      *partial = context.allocate(sums * l * format.accu_bytes());
    }
    for (device::Buffer* scalar : {&rz_[0], &rz_[1], &pq_, &rr_, &bb_}) {
      *scalar = context.allocate(l * format.accu_bytes());
    }
  }

  void begin(InitialGuess /*guess*/) override { fresh_ = first_d_ = true; }
  Norms true_residual(const LaneKernels& kernels, const device::Buffer& b,
                      const device::Buffer& x) override;
  LaneScalars step(const LaneKernels& kernels) override;
  void restart() override { fresh_ = true; }

 private:
  device::Context& context_;
  const Hierarchy& hierarchy_;
  Multigrid multigrid_;
  LaneSums sums_;
  std::size_t cells_;
  std::size_t real_bytes_;
  device::Buffer r_, d_, z_, p_, q_, partial_, partial_bb_;
  device::Buffer rz_[2], pq_, rr_, bb_;
  int now_ = 0;
  bool fresh_ = true;    ///< no direction yet
  bool first_d_ = true;  ///< d is zero, whatever its buffer holds
};

CgSteps::Norms FlatSteps::true_residual(const LaneKernels& kernels, const device::Buffer& b,
                                        const device::Buffer& x) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  if (!first_d_) {
    const int runs = kernels.runs(cells_);
    context_.launch(kernels.vectors(), "renormalise", kernels.items(static_cast<std::size_t>(runs)),
                    static_cast<int>(cells_), runs, x, d_);
  }
  context_.launch(kernels.level_operator(), "residual_accurate", kernels.rows(s), s.nx, s.ny, s.nz,
                  level.gx, level.gy, level.gz, level.sink, int{!first_d_}, x, d_, b, r_, partial_,
                  partial_bb_);
  const std::size_t count = row_sums(s, kernels.layout());
  sums_.add_up(kernels, partial_, count, rr_);
  sums_.add_up(kernels, partial_bb_, count, bb_);
  return {sums_.read(kernels, rr_), sums_.read(kernels, bb_)};
}

LaneScalars FlatSteps::step(const LaneKernels& kernels) {
  const int cells = static_cast<int>(cells_);
  const int runs = kernels.runs(cells_);
  const device::Range run_items = kernels.items(static_cast<std::size_t>(runs));
  const device::Buffer& rz = rz_[now_];
  const device::Buffer& rz_before = rz_[1 - now_];
  const std::size_t field = cells_ * static_cast<std::size_t>(kernels.lanes()) * real_bytes_;
  if (first_d_) context_.zero(d_, field);
  if (fresh_) {
    context_.zero(p_, field);
    context_.zero(rz_before, rz_before.bytes());
  }

  multigrid_.precondition(kernels, r_, z_, q_);
  context_.launch(kernels.vectors(), "dot_runs", run_items, cells, runs, r_, z_, partial_);
  sums_.add_up(kernels, partial_, static_cast<std::size_t>(runs), rz);
  context_.launch(kernels.vectors(), "update_direction", run_items, cells, runs, rz, rz_before, z_,
                  p_);
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  context_.launch(kernels.level_operator(), "apply_dot", kernels.rows(s), s.nx, s.ny, s.nz,
                  level.gx, level.gy, level.gz, level.sink, p_, q_, partial_);
  sums_.add_up(kernels, partial_, row_sums(s, kernels.layout()), pq_);
  context_.launch(kernels.vectors(), "update_solution", run_items, cells, runs, rz, pq_, p_, q_, d_,
                  r_, partial_);
  sums_.add_up(kernels, partial_, static_cast<std::size_t>(runs), rr_);
  now_ = 1 - now_;
  fresh_ = first_d_ = false;
  return sums_.read(kernels, rr_);
}

}  // namespace

std::unique_ptr<CgSteps> make_flat_steps(device::Context& context, const Format& format,
                                         const Hierarchy& hierarchy, int lanes) {
  return std::make_unique<FlatSteps>(context, format, hierarchy, lanes);
}

}  // namespace kappamu::forward
