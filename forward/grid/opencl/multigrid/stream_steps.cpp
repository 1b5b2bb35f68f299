#include <algorithm>
#include <array>

#include "forward/grid/opencl/multigrid/cg_steps.h"
#include "forward/grid/opencl/multigrid/stream_tiles.h"

namespace kappamu::forward {

namespace {

/// Bytes of cache that a tile's ring of planes should fill: what a core has to itself, and no less,
/// since short rows cost loops and cells computed twice. (256x256x20, 16 patterns, to 1e-6: with
/// 512 KiB of such cache 0.75 s at 512 KiB, 0.64 at 1 MiB, 0.59 at 4 MiB; with 2 MiB of it the
/// three sweeps of an iteration take 76 ms at 4 MiB, 64 at 2 MiB, 74 at 1.5 MiB.)
constexpr std::size_t ring_bytes = std::size_t{2} << 20;

class StreamSteps final : public CgSteps {
 public:
  StreamSteps(device::Context& context, const Format& format, const Hierarchy& hierarchy,
              int lanes);

  void begin(InitialGuess guess) override {
    fresh_ = first_d_ = true;
    first_x_ = zero_ = guess == InitialGuess::zero;
  }
  Norms true_residual(const LaneKernels& kernels, const device::Buffer& b,
                      const device::Buffer& x) override;
  LaneScalars step(const LaneKernels& kernels) override;
  void restart() override { fresh_ = true; }

 private:
  /// Right-hand sides are parts of the direction that is not in use, p_[0] or p_[1], which the
  /// solution of level 1 fills when they are done with. Solutions are read by the next finer level
  /// only: two places serve in turn.
  struct Coarse {
    std::array<device::Buffer, 2> rhs;
    device::Buffer solution;
  };
  struct Plan {
    StreamTiles down, up;  ///< of one level
  };
  static device::Range items(const StreamTiles& tiles) {
    return {1, static_cast<std::size_t>(tiles.count), 1, 1};
  }
  /// Σ over `count` pairs of the first or second.
  LaneScalars pair_sum(const LaneKernels& kernels, const device::Buffer& sums, int count,
                       std::size_t which);
  /// z = M r on level l: one V(1,1) cycle from zero (grid_stream_cycle.cl). The way up mirrors the
  /// way down and restriction is the transpose of interpolation, so M is symmetric.
  void cycle(const LaneKernels& kernels, std::size_t l, const device::Buffer& r,
             const device::Buffer& z);

  device::Context& context_;
  const Hierarchy& hierarchy_;
  LaneSums sums_;
  std::vector<Coarse> coarse_;  ///< of levels 2, 3, ...
  std::vector<Plan> plans_;     ///< of levels 0, 1, ...
  StreamTiles step_tiles_, residual_tiles_;
  device::Buffer r_, d_, z_;  ///< on red cells
  std::array<device::Buffer, 2> p_;
  device::Buffer scratch_, scalars_, cycle_dots_, step_sums_, residual_sums_;
  std::size_t now_ = 0;
  bool fresh_ = true;     ///< no direction yet
  bool first_d_ = true;   ///< d is zero, whatever its buffer holds
  bool first_x_ = false;  ///< x is zero on red cells
  bool zero_ = false;     ///< x + d is
};

StreamSteps::StreamSteps(device::Context& context, const Format& format, const Hierarchy& hierarchy,
                         int lanes)
    : context_(context), hierarchy_(hierarchy), sums_(context, format) {
  const std::size_t vector = static_cast<std::size_t>(lanes) * format.real_bytes();
  const auto& levels = hierarchy.levels();
  const StreamMachine machine{static_cast<int>(std::max(1U, context.info().compute_units)),
                              static_cast<int>(ring_bytes / vector)};
  std::size_t scratch = 1;
  const auto need = [&](const StreamTiles& tiles) {
    scratch = std::max(scratch, static_cast<std::size_t>(tiles.count) *
                                    static_cast<std::size_t>(tiles.scratch_cells));
  };
  for (std::size_t l = 0; l + 1 < levels.size(); ++l) {
    const GridShape& below = levels[l + 1].shape;
    plans_.push_back({tiles_down(machine, levels[l].shape, below, levels[l].halving),
                      tiles_up(machine, levels[l].shape, below)});
    need(plans_.back().down);
    need(plans_.back().up);
  }
  const GridShape& finest = hierarchy.finest().shape;
  step_tiles_ = tiles_step(machine, finest);
  need(step_tiles_);
  residual_tiles_ = tiles_residual(machine, finest);
  need(residual_tiles_);
  const std::size_t red_bytes = half_cells(finest) * vector;
  const std::size_t level_1 = levels[levels.size() > 1 ? 1 : 0].shape.cells() * vector;
  std::size_t right_sides = 0;  // of levels 2, 3, ...
  const auto part_bytes = [&](std::size_t l) {
    constexpr std::size_t unit = device::Context::part_alignment;
    return (levels[l].shape.cells() * vector + unit - 1) / unit * unit;
  };
  for (std::size_t l = 2; l < levels.size(); ++l) right_sides += part_bytes(l);
  Workspace& work = hierarchy.workspace();
  work.begin(red_bytes);
  for (device::Buffer* field : {&r_, &d_}) *field = work.take(red_bytes);
  z_ = work.take(std::max(red_bytes, level_1));
  for (device::Buffer& p : p_) p = work.take(std::max({red_bytes, level_1, right_sides}));
  std::size_t offset = 0;
  for (std::size_t l = 2; l < levels.size(); ++l) {
    const std::size_t bytes = levels[l].shape.cells() * vector;
    coarse_.push_back({{context.part(p_[0], offset, bytes), context.part(p_[1], offset, bytes)},
                       l < 4 ? work.take(bytes) : coarse_[l - 4].solution});
    offset += part_bytes(l);
  }
  scratch_ = context.allocate(scratch * vector);
  const std::size_t scalar = static_cast<std::size_t>(lanes) * format.accu_bytes();
  scalars_ = context.allocate(3 * scalar);
  cycle_dots_ = context.allocate(
      2 * scalar * static_cast<std::size_t>(plans_.empty() ? 1 : plans_.front().up.sums));
  residual_sums_ = context.allocate(2 * scalar * static_cast<std::size_t>(residual_tiles_.sums));
  step_sums_ = context.allocate(2 * scalar * static_cast<std::size_t>(step_tiles_.sums));
}

void StreamSteps::cycle(const LaneKernels& kernels, std::size_t l, const device::Buffer& r,
                        const device::Buffer& z) {
  const Level& at = hierarchy_.levels()[l];
  const Level& below = hierarchy_.levels()[l + 1];
  const GridShape& s = at.shape;
  const GridShape& c = below.shape;
  // Coarse levels borrow what the finest level fills only afterwards: z, and the next direction.
  const std::size_t idle = 1 - now_;
  const device::Buffer& coarse_rhs = l == 0 ? z : coarse_[l - 1].rhs[idle];
  const device::Buffer& coarse_solution = l == 0 ? p_[idle] : coarse_[l - 1].solution;
  const StreamTiles& down = plans_[l].down;
  context_.launch(kernels.steps(), "stream_down", items(down), down.size[0], down.size[1],
                  down.size[2], int{l == 0}, s.nx, s.ny, s.nz, at.stencils, c.nx, c.ny, c.nz,
                  at.halving[0], at.halving[1], at.halving[2], at.weights, r, coarse_rhs,
                  down.scratch_cells, scratch_);
  if (l + 2 < hierarchy_.levels().size()) {
    cycle(kernels, l + 1, coarse_rhs, coarse_solution);
  } else {
    context_.launch(kernels.steps(), "solve_last", {1, 1, 1, 1}, static_cast<int>(c.cells()),
                    below.solve, coarse_rhs, coarse_solution);
  }
  const StreamTiles& up = plans_[l].up;
  context_.launch(kernels.steps(), "stream_up", items(up), up.size[0], up.size[1], up.size[2],
                  int{l == 0}, s.nx, s.ny, s.nz, at.stencils, c.nx, c.ny, c.nz, at.halving[0],
                  at.halving[1], at.halving[2], at.weights, r, coarse_solution, z, cycle_dots_,
                  up.scratch_cells, scratch_);
}

CgSteps::Norms StreamSteps::true_residual(const LaneKernels& kernels, const device::Buffer& b,
                                          const device::Buffer& x) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  const StreamTiles& tiles = zero_ ? step_tiles_ : residual_tiles_;
  const device::Buffer& sums = zero_ ? step_sums_ : residual_sums_;
  if (zero_) {
    context_.launch(kernels.residual(), "residual_of_zero", items(tiles), tiles.size[0],
                    tiles.size[1], tiles.size[2], s.nx, s.ny, s.nz, level.stencils, b, x, r_, sums);
  } else {
    // As in grid_reduced.cl.
    enum Parts : int { x_and_d, x_alone, d_alone };
    const Parts parts = first_d_ ? x_alone : first_x_ ? d_alone : x_and_d;
    if (parts == x_and_d) {
      context_.launch(kernels.residual(), "renormalise_red", kernels.items(rows_of(s)), s.nx, s.ny,
                      s.nz, x, d_);
    }
    context_.launch(kernels.residual(), "reduced_residual", items(tiles), tiles.size[0],
                    tiles.size[1], tiles.size[2], s.nx, s.ny, s.nz, level.stencils, int{parts}, d_,
                    b, x, r_, sums, tiles.scratch_cells, scratch_);
    first_d_ = parts != x_and_d;  // x has all of it
    first_x_ = false;
  }
  return {pair_sum(kernels, sums, tiles.sums, 0), pair_sum(kernels, sums, tiles.sums, 1)};
}

LaneScalars StreamSteps::pair_sum(const LaneKernels& kernels, const device::Buffer& sums, int count,
                                  std::size_t which) {
  const auto lanes = static_cast<std::size_t>(kernels.lanes());
  const auto pairs = static_cast<std::size_t>(count);
  const LaneScalars all = sums_.read(kernels, sums, 2 * pairs);
  LaneScalars total(lanes, 0.0);
  for (std::size_t k = 0; k < pairs; ++k) {
    for (std::size_t m = 0; m < lanes; ++m) total[m] += all[(2 * k + which) * lanes + m];
  }
  return total;
}

LaneScalars StreamSteps::step(const LaneKernels& kernels) {
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  if (plans_.empty()) {
    context_.launch(kernels.steps(), "cycle_of_one_cell", {1, 1, 1, 1}, level.stencils, r_, z_,
                    cycle_dots_);
  } else {
    cycle(kernels, 0, r_, z_);
  }
  const int up_sums = plans_.empty() ? 1 : plans_.front().up.sums;
  context_.launch(kernels.steps(), "step_scalars", {1, 1, 1, 1}, up_sums, step_tiles_.sums,
                  int{fresh_}, cycle_dots_, step_sums_, scalars_);
  context_.launch(kernels.steps(), "stream_step", items(step_tiles_), step_tiles_.size[0],
                  step_tiles_.size[1], step_tiles_.size[2], int{fresh_}, int{first_d_}, s.nx, s.ny,
                  s.nz, level.stencils, scalars_, z_, p_[now_], p_[1 - now_], d_, r_, step_sums_,
                  step_tiles_.scratch_cells, scratch_);
  now_ = 1 - now_;
  fresh_ = first_d_ = zero_ = false;
  return pair_sum(kernels, step_sums_, step_tiles_.sums, 0);
}

}  // namespace

std::unique_ptr<CgSteps> make_stream_steps(device::Context& context, const Format& format,
                                           const Hierarchy& hierarchy, int lanes) {
  return std::make_unique<StreamSteps>(context, format, hierarchy, lanes);
}

}  // namespace kappamu::forward
