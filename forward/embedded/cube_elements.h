// Coefficients and element matrices of a mesh's cubes.
#pragma once

#include <vector>

#include "forward/embedded/element.h"
#include "forward/embedded/geometry/cut_mesh.h"

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

}  // namespace kappamu::forward::embedded
