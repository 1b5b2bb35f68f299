// One object on one octree, in several media (colour channels) at once: from lights to exitances.
#pragma once

#include <algorithm>
#include <memory>
#include <span>

#include "core/optics.h"
#include "forward/embedded/beams.h"
#include "forward/embedded/equations/levels.h"
#include "forward/embedded/equations/linear_solver.h"

namespace kappamu::forward::embedded {

struct Discretisation {
  Octree tree;
  CutMesh mesh;
  std::vector<std::vector<Coefficients>> coefficients;  ///< [channel][cube]
  Levels levels;

  /// One channel per medium.
  Discretisation(Octree octree, CutMesh cut, std::span<const ObjectMedium* const> media, double A);
  const NodeSpace& space() const { return levels.space(); }
};

/// Problems that differ in medium and lights alone, one per channel, with the chords of their
/// beams.
struct Channels {
  std::vector<ObjectProblem> problems;
  BoundaryConstants constants;
  /// [channel][light]; channels whose beams run alike share them.
  std::vector<std::vector<std::shared_ptr<const std::vector<Chord>>>> chords;

  explicit Channels(std::span<const ObjectProblem> problems);
  std::vector<const ObjectMedium*> media() const;
  std::size_t lights() const;  ///< of all channels together
};

/// Of one channel.
struct Answer {
  std::vector<std::vector<double>> fluence;   ///< [light][unknown]
  std::vector<std::vector<double>> exitance;  ///< [light][triangle]
  std::vector<ObjectBalance> balance;
};

struct Answers {
  std::vector<Answer> channel;
  CgReport report;
};

/// Relative residual of the linear systems for exitances of this relative tolerance, of which what
/// it leaves open is some percent (measured: 20 times the residual). The powers balance whatever it
/// is.
inline double linear_tolerance(double tolerance) {
  return std::min(1e-5, 2e-3 * tolerance);
}

Answers answers(const Discretisation& discretisation, const Channels& channels,
                LinearSolver& solver, double linear_tolerance);

}  // namespace kappamu::forward::embedded
