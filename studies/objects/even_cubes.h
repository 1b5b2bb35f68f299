// Diffusion on cubes of one size: model `embedded` without its refinement.
#pragma once

#include "forward/embedded/discretisation.h"

namespace kappamu::studies {

class EvenCubes {
 public:
  /// On 2^level cubes along the root's edge, everywhere or at the surface alone. Keeps a reference
  /// to the problem's parts.
  EvenCubes(const forward::ObjectProblem& problem, int level, bool everywhere);

  std::size_t count() const { return discretisation_.mesh.cubes.size(); }
  /// Assembles the equations where they are solved.
  std::unique_ptr<forward::embedded::LinearSolver> solver(const std::string& device) const;
  /// Solves as tightly as a relative tolerance of the exitance asks for.
  forward::embedded::Answers answers(forward::embedded::LinearSolver& solver,
                                     double tolerance) const;

 private:
  forward::embedded::Channels channels_;
  forward::embedded::Discretisation discretisation_;
};

}  // namespace kappamu::studies
