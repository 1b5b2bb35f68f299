// The levels of the multigrid preconditioner: conductances from κ and μ, coarsened twofold level by
// level down to a few cells, each time along the axes of strong coupling:
// those whose mean share of a cell's conductance, (G₋ + G₊)/D, is at least half the largest. In an
// even medium these are all; where layers conduct far better along themselves than across, they are
// merged along themselves only, since no coarse value could stand for two of them. A coarse face
// conductance is the energy PᵀAP gives a step across it, P being the interpolation
// (grid_coarsen.cl), a coarse cell's node lying nearer to its better conducting child, so that
// barriers and channels of κ survive coarsening; absorption adds up.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "device/context.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/kernels/grid_kernels.h"
#include "forward/grid/opencl/multigrid/workspace.h"

namespace kappamu::forward {

struct Level {
  GridShape shape;
  std::array<int, 3> halving{1, 1,
                             1};  ///< axes coarsened twofold towards the next level (1) or not (0)
  /// What a solve reads of a cell, together: Stencil and Weights in grid_stencil_prelude.cl; the
  /// weights interpolate from the next level and mean nothing on the last.
  device::Buffer stencils, weights;
  /// With Layout::gpu: the stencils' smoother once more, [z][y][x].
  device::Buffer smoother;
  /// Of the last level: the inverse of its matrix, for solve_last() of either layout.
  device::Buffer solve;
};

class Hierarchy {
 public:
  /// The first level under the finest of at most `cells_to_invert` is the last: starting the
  /// kernels of smaller ones takes longer than all their arithmetic.
  Hierarchy(device::Context& context, const Format& format, Layout layout, const GridSetup& setup,
            double robin_A, std::size_t cells_to_invert = 64);

  /// From κ and μ, [z][y][x]. Returns whether the levels' shapes have changed: work space made for
  /// them is then void.
  bool set_medium(const device::Buffer& kappa, const device::Buffer& mu);
  bool has_medium() const { return has_medium_; }
  const std::vector<Level>& levels() const { return levels_; }
  const Level& finest() const { return levels_.front(); }
  /// Used by set_medium(); between two calls it is the solver's.
  Workspace& workspace() const { return workspace_; }

 private:
  /// What only the set-up needs of a level; layouts: grid_operator.cl.
  struct Arrays {
    device::Buffer gx, gy, gz, sink;
  };
  /// Places for all levels in turn.
  struct SetUp {
    std::array<Arrays, 2> of_level;  ///< even and odd ones
    device::Buffer inverse;          ///< 1 / (Σ G + S) of each cell
    device::Buffer loose;            ///< of invert_diagonal; then, with Layout::cpu, the smoother
    device::Buffer weight;           ///< of interpolation across one axis
  };
  Arrays take_arrays(const GridShape& shape) const;
  std::array<int, 3> strong_axes(const GridShape& shape, const Arrays& fine,
                                 const device::Buffer& inverse) const;
  /// The level under `l`, allocated anew if another shape was there.
  bool ensure_level(std::size_t l);
  /// Fills `coarse`, the arrays of the level below, and the level's weights.
  void coarsen(const Level& level, const GridShape& below, const Arrays& fine, const Arrays& coarse,
               const SetUp& set_up) const;
  /// `sums` of coarse cells or faces from the `values` of the fine ones in them.
  void sum_children(const GridShape& fine, const GridShape& coarse,
                    const std::array<int, 3>& halving, const device::Buffer& values,
                    const device::Buffer& sums) const;
  void make_smoother(const GridShape& shape, const Arrays& arrays, const device::Buffer& inverse,
                     const device::Buffer& smoother) const;
  bool is_last(std::size_t l) const;
  void invert_matrix(Level& level, const Arrays& arrays) const;
  Level allocate_level(const GridShape& shape) const;

  device::Context& context_;
  Format format_;
  Layout layout_;
  GridSetup setup_;
  double robin_A_;
  std::size_t cells_to_invert_;
  device::Program& program_;
  mutable Workspace workspace_;
  std::vector<Level> levels_;
  bool has_medium_ = false;
};

/// The level below `shape` that is halved along the axes with 1.
GridShape coarser_grid(const GridShape& shape, const std::array<int, 3>& halving = {1, 1, 1});

/// Cells of one parity of x, rows of odd length counted as if one longer: half of what `stencils`
/// holds, all that `weights` does.
std::size_t half_cells(const GridShape& shape);
/// Reals of a cell in them.
constexpr std::size_t stencil_reals = 8, weight_reals = 3;

/// Rows along x.
inline std::size_t rows_of(const GridShape& shape) {
  return shape.cells() / static_cast<std::size_t>(shape.nx);
}

/// Elements of the face array across `axis`: one more than cells along it.
std::size_t face_count(const GridShape& shape, int axis);

/// Copies host doubles to a buffer of `format`'s reals.
void upload(device::Context& context, const Format& format, std::span<const double> values,
            const device::Buffer& buffer);
/// The same into a buffer of their size.
device::Buffer uploaded(device::Context& context, const Format& format,
                        std::span<const double> values);

}  // namespace kappamu::forward
