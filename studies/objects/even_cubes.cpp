#include "studies/objects/even_cubes.h"

#include "forward/embedded/solver_choice.h"

namespace kappamu::studies {

using namespace forward::embedded;

namespace {

Octree even_octree(const TriangleMesh& mesh, int level, bool everywhere) {
  Octree tree(mesh);
  if (everywhere) {
    for (int split = 0; split < level; ++split) tree.refine_each(tree.leaves());
  } else {
    tree.refine_surface(level);
  }
  return tree;
}

Discretisation discretised(const forward::ObjectProblem& problem, Octree tree,
                           const Channels& channels) {
  CutMesh mesh = cut_mesh(tree, problem.mesh, problem.rays);
  return {std::move(tree), std::move(mesh), channels.media(), channels.constants.A};
}

}  // namespace

EvenCubes::EvenCubes(const forward::ObjectProblem& problem, int level, bool everywhere)
    : channels_(std::span(&problem, 1)),
      discretisation_(
          discretised(problem, even_octree(problem.mesh, level, everywhere), channels_)) {}

std::unique_ptr<LinearSolver> EvenCubes::solver(const std::string& device) const {
  return make_linear_solver(discretisation_.levels, channels_.lights(), device);
}

Answers EvenCubes::answers(LinearSolver& solver, double tolerance) const {
  return forward::embedded::answers(discretisation_, channels_, solver,
                                    linear_tolerance(tolerance));
}

}  // namespace kappamu::studies
