// The V-cycle, once: the model gives its levels as row matrices, a backend (host or OpenCL) the
// operations on them.
//
// The smoother is Chebyshev's polynomial of the fourth kind (Lottes 2023), which needs nothing but
// a bound of the scaled spectrum; the same before and after the coarse correction, so that the
// cycle is symmetric.
#pragma once

#include <vector>

#include "forward/linear/row_matrix.h"

namespace kappamu::forward::linear {

struct RowLevel {
  RowMatrix<double> equations;  ///< what is solved on this level; none where nothing is
  RowMatrix<float> matrix;      ///< what the V-cycle smooths; none on the coarsest
  /// [row][medium] 1/d with A ≤ diag(d): the eigenvalues of diag(1/d) A lie in (0, 1]. Zero where
  /// the equation weighs nothing.
  std::vector<float> inverse_scale;
  RowMatrix<float> interpolation;  ///< of one medium, from the next coarser level
  RowMatrix<float> restriction;    ///< its transpose
  std::size_t rows = 0;
  int smoothing_degree = 1;
};

/// The levels of the media of a batch of lanes, finest first.
struct RowLevels {
  std::vector<RowLevel> level;
  std::vector<float> coarsest;  ///< [row][column][medium] inverse of the coarsest level's matrix
};

/// Step k ≥ 2 of the smoother: z ← keep·z + gain·r/d after r ← r − A z; the first is gain·r/d.
struct SmoothingStep {
  float keep, gain;
};
constexpr SmoothingStep smoothing_step(int k) {
  const auto n = static_cast<float>(k);
  return {(2.0F * n - 3.0F) / (2.0F * n + 1.0F), (8.0F * n - 4.0F) / (2.0F * n + 1.0F)};
}

/// What a smoother's x begins with.
enum class Start { zero, given };

/// Turns the residual r of a level into the correction x; r is used up. Per level the operations
/// keep r, x and the last step z, and
///   smooth_first(l, start)   z = gain r/d; x = z or x + z
///   smooth_next(l, k)        r −= A z, then z = keep z + gain r/d; x += z
///   subtract_product(l)      r −= A z
///   restrict_to(l + 1)       r of the coarser level
///   prolong_to(l)            z = the coarser level's x, interpolated; x += z
///   solve_directly(l)        x = A⁻¹ r
template <class Operations>
void v_cycle(Operations& on, const RowLevels& levels, std::size_t l) {
  if (l + 1 == levels.level.size()) {
    on.solve_directly(l);
    return;
  }
  // The last step stays in z, not yet subtracted from r.
  const auto smooth = [&](Start start) {
    on.smooth_first(l, start);
    for (int k = 2; k <= levels.level[l].smoothing_degree; ++k) on.smooth_next(l, k);
  };
  smooth(Start::zero);
  on.subtract_product(l);
  on.restrict_to(l + 1);
  v_cycle(on, levels, l + 1);
  on.prolong_to(l);
  on.subtract_product(l);
  smooth(Start::given);
}

}  // namespace kappamu::forward::linear
