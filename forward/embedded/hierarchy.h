// The system matrix of a cut mesh and its coarser versions, level by level: every level replaces
// the smallest cubes by their parents. Coarse functions are fine ones too, so that the sum of a
// parent's children (element.h) is the exact Galerkin matrix, with cut cubes and hanging nodes as
// without.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "forward/embedded/cut_mesh.h"
#include "forward/embedded/element.h"
#include "forward/embedded/node_space.h"
#include "forward/embedded/sparse_rows.h"

namespace kappamu::forward::embedded {

/// Elements of a list of cubes; equal ones may be stored once.
struct Elements {
  std::vector<Element> element;
  std::vector<int> of_cube;  ///< place in `element`
  const Element& of(std::size_t cube) const {
    return element[static_cast<std::size_t>(of_cube[cube])];
  }
};

/// κ and μ of every cube: the medium's mean over it.
std::vector<Coefficients> cube_coefficients(const CutMesh& mesh, const Octree& tree,
                                            const ObjectMedium& medium);
Elements cube_elements(const CutMesh& mesh, const std::vector<Coefficients>& coefficients,
                       double A);

/// One level, in the precision of the preconditioner.
struct Level {
  SparseRows<float> matrix;
  /// 1/d with A ≤ diag(d): the eigenvalues of diag(1/d) A lie in (0, 1].
  std::vector<float> inverse_scale;
  SparseRows<float> interpolation;  ///< rows: unknowns here; columns: of the next coarser level
  SparseRows<float> restriction;    ///< its transpose
};

struct Hierarchy {
  NodeSpace space;            ///< of the finest level
  SparseRows<double> matrix;  ///< of the finest level
  std::vector<Level> levels;  ///< finest first
  Eigen::LLT<Eigen::MatrixXd> coarsest;

  std::size_t unknowns() const { return space.unknowns(); }
};

Hierarchy make_hierarchy(const CutMesh& mesh, Elements elements);

}  // namespace kappamu::forward::embedded
