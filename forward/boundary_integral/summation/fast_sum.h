// Sums of Yukawa potentials of N elements at N places in time and memory linear in N: the
// kernel-independent fast multipole method on an octree that follows the elements.
//
// An element is a few points that share one strength (sources) or one mean (targets). Pairs whose
// boxes touch are summed directly; there a caller may put its own value, a singular integral, in
// the points' place. Boxes so far apart that e^−λr ends all are left out.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "forward/boundary_integral/summation/octree.h"
#include "forward/boundary_integral/summation/point_kernel.h"

namespace kappamu::forward::boundary_integral {

struct SumElements {
  int points = 1;                       ///< of each element
  std::vector<Eigen::Vector3d> centre;  ///< of each element [mm]
  std::vector<Eigen::Vector3d> at;      ///< [element][point] [mm]
};

struct SumSources : SumElements {
  std::vector<double> charge;           ///< [element][point], of unit strength
  std::vector<Eigen::Vector3d> dipole;  ///< the same; empty: none
};

/// What a pair of elements whose boxes touch adds, where it is not the sum over points.
using NearValue = std::function<std::optional<double>(int target, int source)>;

/// The order that keeps the sum's error below `accuracy`, relative in the 2-norm (measured:
/// tests/forward/boundary_integral).
int sum_order(double accuracy);

class FastSum {
 public:
  enum class Keep {
    matrices,  ///< for further sums: 4 to 6 kB an element
    nothing    ///< made anew for every sum
  };
  struct Options {
    double decay = 0.0;  ///< λ [1/mm]
    int order = 6;       ///< points along the edges of equivalent cubes: sum_order()
    int leaf = 60;       ///< elements in a box that is not split
    Keep keep = Keep::matrices;
  };

  FastSum(SumSources sources, SumElements targets, NearValue near, const Options& options);
  ~FastSum();
  FastSum(FastSum&&) noexcept;

  /// value(target) = Σ_sources strength · potential, mean over the target's points.
  Eigen::VectorXd operator()(const Eigen::VectorXd& strength) const;
  std::size_t bytes() const;  ///< kept

 private:
  class Plan;
  std::unique_ptr<Plan> plan_;
};

}  // namespace kappamu::forward::boundary_integral
