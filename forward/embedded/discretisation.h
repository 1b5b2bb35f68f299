// One object on one octree, in several media (colour channels) at once: from lights to exitances.
#pragma once

#include <algorithm>
#include <memory>
#include <span>

#include "core/optics.h"
#include "forward/embedded/beams.h"
#include "forward/embedded/equations/levels.h"
#include "forward/linear/linear_solver.h"

namespace kappamu::forward::embedded {

using linear::CgEnd;
using linear::CgReport;
using linear::LinearSolver;
using linear::Load;

struct Discretisation {
  Octree tree;
  CutMesh mesh;
  std::vector<std::vector<Coefficients>> coefficients;  ///< [channel][cube]
  Levels levels;

  /// One channel per medium.
  Discretisation(Octree octree, CutMesh cut, std::span<const ObjectMedium* const> media, double A);
  const NodeSpace& space() const { return levels.space(); }
};

/// Problems that differ in medium and lights alone, one per channel, with the paths of their
/// beams.
struct Channels {
  std::vector<ObjectProblem> problems;
  BoundaryConstants constants;
  MeshWalls walls;
  /// [channel][light]; channels whose beams run alike share them.
  std::vector<std::vector<std::shared_ptr<BeamPaths>>> paths;

  explicit Channels(std::span<const ObjectProblem> problems);
  Channels(const Channels&) = delete;  // paths refer to its walls
  Channels& operator=(const Channels&) = delete;
  std::vector<const ObjectMedium*> media() const;
  std::size_t lights() const;  ///< of all channels together
};

/// Of one channel.
struct Answer {
  std::vector<std::vector<double>> fluence;   ///< [light][unknown]
  std::vector<std::vector<double>> exitance;  ///< [light][triangle]
  /// The same on the next coarser level, with the finest one's coefficients; empty: there is none.
  std::vector<std::vector<double>> coarser_exitance;
  std::vector<ObjectBalance> balance;
  std::vector<std::vector<Beam>> leaving;  ///< [light], unscattered
};

struct Answers {
  std::vector<Answer> channel;
  int iterations = 0;
  bool converged = true;
};

/// Of exitances of this relative tolerance, what the linear systems may leave open. The powers
/// balance whatever it is.
inline double linear_tolerance(double tolerance) {
  return std::min(1e-5, 0.1 * tolerance);
}

/// Solves on the level below the finest first and begins from there. The linear systems leave a
/// relative error of `linear_tolerance` at most, in the surface's 2-norm.
Answers answers(const Discretisation& discretisation, const Channels& channels,
                LinearSolver& solver, double linear_tolerance);

}  // namespace kappamu::forward::embedded
