// The levels of the multigrid preconditioner: conductances from κ and μ, coarsened twofold along
// every axis longer than one cell, down to a single cell. A coarse face conductance is the parallel
// sum over the fine faces of series resistances from node to node, a coarse cell's
// node lying nearer to its better conducting child, so that barriers and channels of κ survive
// coarsening; absorption adds up. (With nodes midway, random κ of contrast 1e4 on 128x128x20 voxels
// took 122 iterations instead of 33, blocks of it more than 400 instead of 34.)
#pragma once

#include <array>
#include <span>
#include <vector>

#include "device/context.h"
#include "forward/grid/grid_kernels.h"
#include "forward/grid/grid_solver.h"

namespace kappamu::forward {

struct Level {
  GridShape shape;
  std::array<int, 3> halving{1, 1,
                             1};  ///< axes coarsened twofold towards the next level (1) or not (0)
  device::Buffer gx, gy, gz, sink;  ///< layouts: grid_operator.cl
  device::Buffer inverse;           ///< 1 / (Σ G + S) of each cell
  device::Buffer smoother;          ///< make_smoother in grid_assemble.cl
  device::Buffer wx, wy, wz;        ///< interpolation weights from the next level; none on the last
};

class Hierarchy {
 public:
  Hierarchy(device::Context& context, const Format& format, const GridSetup& setup, double robin_A);

  void set_medium(std::span<const double> kappa, std::span<const double> mu);
  bool has_medium() const { return has_medium_; }
  const std::vector<Level>& levels() const { return levels_; }
  const Level& finest() const { return levels_.front(); }

 private:
  void coarsen(const Level& fine, const Level& coarse);

  device::Context& context_;
  Format format_;
  GridSetup setup_;
  double robin_A_;
  device::Program& program_;
  device::Buffer kappa_, mu_;
  std::vector<Level> levels_;
  bool has_medium_ = false;
};

/// The level below `shape`.
GridShape coarser_grid(const GridShape& shape);

/// Elements of the face array across `axis`: one more than cells along it.
std::size_t face_count(const GridShape& shape, int axis);

/// Copies host doubles to a buffer of `format`'s reals.
void upload(device::Context& context, const Format& format, std::span<const double> values,
            const device::Buffer& buffer);

}  // namespace kappamu::forward
