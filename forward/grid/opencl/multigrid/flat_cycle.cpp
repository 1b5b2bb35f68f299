#include "forward/grid/opencl/multigrid/flat_cycle.h"

namespace kappamu::forward {

FlatCycle::FlatCycle(device::Context& context, const Format& format, const Hierarchy& hierarchy,
                     int lanes)
    : context_(context), hierarchy_(hierarchy) {
  for (std::size_t l = 1; l < hierarchy.levels().size(); ++l) {
    const std::size_t bytes = half_cells(hierarchy.levels()[l].shape) *
                              static_cast<std::size_t>(lanes) * format.real_bytes();
    Workspace& work = hierarchy.workspace();
    coarse_.push_back({work.take(2 * bytes), work.take(2 * bytes), work.take(bytes)});
  }
}

void FlatCycle::precondition(const LaneKernels& kernels, const device::Buffer& r,
                             const device::Buffer& z, const device::Buffer& scratch,
                             const device::Buffer& partial) const {
  const Fields finest{r, z, scratch};
  const std::size_t last = coarse_.size();
  const auto fields = [&](std::size_t l) { return l == 0 ? finest : coarse_[l - 1]; };
  for (std::size_t l = 0; l < last; ++l) down(kernels, l, fields(l), fields(l + 1).rhs);
  const Level& coarsest = hierarchy_.levels().back();
  const std::size_t places = 2 * half_cells(coarsest.shape);
  context_.launch(kernels.steps(), "solve_last", kernels.flat(places), static_cast<int>(places),
                  coarsest.solve, fields(last).rhs, fields(last).solution);
  for (std::size_t l = last; l > 0; --l) up(kernels, l - 1, fields(l - 1), fields(l).solution);
  const Level& level = hierarchy_.finest();
  const GridShape& s = level.shape;
  context_.launch(kernels.steps(), "relax_and_sum", kernels.summed(s), s.nx, s.ny, s.nz,
                  level.stencils, r, z, partial);
}

void FlatCycle::down(const LaneKernels& kernels, std::size_t l, const Fields& at,
                     const device::Buffer& coarse) const {
  const Level& level = hierarchy_.levels()[l];
  const GridShape& s = level.shape;
  const GridShape& c = hierarchy_.levels()[l + 1].shape;
  const device::Range items = kernels.tiled(s);
  device::Program& program = kernels.steps();
  if (l > 0) {
    context_.launch(program, "reduce", items, s.nx, s.ny, s.nz, level.stencils, level.smoother,
                    at.rhs);
  }
  context_.launch(program, "solve_black_first", items, s.nx, s.ny, s.nz, level.stencils,
                  level.smoother, at.rhs, at.solution);
  context_.launch(program, "residual_of_first", items, s.nx, s.ny, s.nz, level.stencils, at.rhs,
                  at.solution, at.residual);
  context_.launch(program, "restrict_residual", kernels.tiled_cells(c), s.nx, s.ny, s.nz, c.nx,
                  c.ny, c.nz, level.halving[0], level.halving[1], level.halving[2], level.weights,
                  at.residual, coarse);
}

void FlatCycle::up(const LaneKernels& kernels, std::size_t l, const Fields& at,
                   const device::Buffer& coarse) const {
  const Level& level = hierarchy_.levels()[l];
  const GridShape& s = level.shape;
  const GridShape& c = hierarchy_.levels()[l + 1].shape;
  const device::Range items = kernels.tiled(s);
  device::Program& program = kernels.steps();
  const auto solve_black = [&](bool with_rhs) {
    context_.launch(program, "solve_black", items, s.nx, s.ny, s.nz, level.stencils, int{with_rhs},
                    at.rhs, at.solution);
  };
  context_.launch(program, "correct_first", items, s.nx, s.ny, s.nz, level.stencils, c.nx, c.ny,
                  c.nz, level.halving[0], level.halving[1], level.halving[2], level.weights, at.rhs,
                  coarse, at.solution);
  solve_black(false);
  if (l == 0) return;  // relaxed with a sum
  context_.launch(program, "relax", items, s.nx, s.ny, s.nz, level.stencils, at.rhs, at.solution);
  solve_black(true);
}

}  // namespace kappamu::forward
