// What share of the memory's bandwidth each kernel of a solve uses on the finest grid, where nearly
// all of the time goes: seconds as the device itself times them, bytes as the algorithm must move
// them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "studies/forward/problem.h"
#include "studies/record.h"

namespace kappamu::studies {

struct KernelUse {
  std::string kernel;
  double launches = 0.0;        ///< per solve
  double seconds = 0.0;         ///< of one launch, median
  double solve_seconds = 0.0;   ///< of all its launches in a solve, mean
  std::optional<double> bytes;  ///< one launch must move, where that is stated
};

struct KernelProfile {
  std::string precision;
  int iterations = 0;
  double solve_seconds = 0.0;   ///< wall time of a solve, median
  double coarse_seconds = 0.0;  ///< kernels on coarser grids and sums, per solve
  double bandwidth = 0.0;  ///< measured_copy_bandwidth() [bytes/s], before or after, the better
  std::vector<KernelUse> finest;  ///< in order of first launch

  /// Bytes of all launches on the finest grid whose bytes are stated, over their seconds and the
  /// bandwidth.
  double finest_fraction() const;
};

/// Bytes a launch of `kernel` must move on a finest grid of `cells` above one of `coarse_cells`,
/// for `lanes` patterns: every vector and coefficient it names once, none that a cache could keep
/// (docs/engine.md). Nothing for a kernel it does not know.
std::optional<double> kernel_bytes(const std::string& kernel, std::size_t cells,
                                   std::size_t coarse_cells, int lanes, std::size_t real_bytes);

/// Solves all patterns to 1e-6 `repetitions` times, from zero. Needs an OpenCL device; patterns in
/// one batch.
KernelProfile profile_kernels(const ProblemSpec& spec, const std::string& device,
                              forward::Precision precision, int repetitions);

Json to_json(const KernelProfile& profile);

}  // namespace kappamu::studies
