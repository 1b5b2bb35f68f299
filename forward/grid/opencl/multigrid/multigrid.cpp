#include "forward/grid/opencl/multigrid/multigrid.h"

namespace kappamu::forward {

namespace {
constexpr int red = 0, black = 1;
}

Multigrid::Multigrid(device::Context& context, const Format& format, const Hierarchy& hierarchy,
                     int lanes)
    : context_(context), hierarchy_(hierarchy) {
  for (std::size_t l = 1; l < hierarchy.levels().size(); ++l) {
    const std::size_t bytes =
        hierarchy.levels()[l].shape.cells() * static_cast<std::size_t>(lanes) * format.real_bytes();
    coarse_.push_back({context.allocate(bytes), context.allocate(bytes), context.allocate(bytes)});
  }
}

void Multigrid::precondition(const LaneKernels& kernels, const device::Buffer& r,
                             const device::Buffer& z, const device::Buffer& scratch) const {
  cycle(kernels, 0, {r, z, scratch});
}

void Multigrid::cycle(const LaneKernels& kernels, std::size_t l, const Fields& at) const {
  const Level& level = hierarchy_.levels()[l];
  if (l + 1 == hierarchy_.levels().size()) {  // a single cell, which is red: solved
    return smooth(kernels, "smooth_from_zero", level, level.inverse, red, at);
  }
  smooth(kernels, "smooth_from_zero", level, level.smoother, black, at);
  smooth(kernels, "smooth", level, level.smoother, red, at);
  smooth(kernels, "smooth", level, level.smoother, black, at);
  const GridShape& s = level.shape;
  context_.launch(kernels.level_operator(), "residual_of_colour", kernels.rows(s), s.nx, s.ny, s.nz,
                  level.gx, level.gy, level.gz, level.sink, red, at.solution, at.rhs, at.residual);

  const Fields& below = coarse_[l];
  const GridShape& coarse = hierarchy_.levels()[l + 1].shape;
  transfer(kernels, "restrict_residual", level, coarse, coarse, at.residual, below.rhs);
  cycle(kernels, l + 1, below);
  transfer(kernels, "prolong_add", level, coarse, level.shape, below.solution, at.solution);

  smooth(kernels, "smooth", level, level.smoother, black, at);
  context_.launch(kernels.level_operator(), "relax", kernels.rows(s), s.nx, s.ny, s.nz, level.gx,
                  level.gy, level.gz, level.sink, level.smoother, red, at.solution, at.rhs);
  smooth(kernels, "smooth", level, level.smoother, black, at);
}

void Multigrid::smooth(const LaneKernels& kernels, const char* kernel, const Level& level,
                       const device::Buffer& smoother, int colour, const Fields& at) const {
  const GridShape& s = level.shape;
  context_.launch(kernels.level_operator(), kernel, kernels.rows(s), s.nx, s.ny, s.nz, level.gx,
                  level.gy, level.gz, smoother, colour, at.solution, at.rhs);
}

void Multigrid::transfer(const LaneKernels& kernels, const char* kernel, const Level& fine,
                         const GridShape& coarse, const GridShape& items,
                         const device::Buffer& from, const device::Buffer& to) const {
  const GridShape& s = fine.shape;
  context_.launch(kernels.transfer(), kernel, kernels.rows(items), s.nx, s.ny, s.nz, coarse.nx,
                  coarse.ny, coarse.nz, red, fine.halving[0], fine.halving[1], fine.halving[2],
                  fine.wx, fine.wy, fine.wz, from, to);
}

}  // namespace kappamu::forward
