// Coefficients and element matrices of a mesh's cubes, for several media (colour channels) at once.
#pragma once

#include <span>
#include <vector>

#include "forward/embedded/equations/element.h"
#include "forward/embedded/geometry/cut_mesh.h"

namespace kappamu::forward::embedded {

/// Elements of a list of cubes; equal ones may be stored once.
struct Elements {
  std::size_t channels = 1;
  std::vector<Element> element;  ///< [place][channel]
  std::vector<int> of_cube;      ///< place

  std::size_t places() const { return element.size() / channels; }
  const Element& of(std::size_t cube, std::size_t channel) const {
    return element[static_cast<std::size_t>(of_cube[cube]) * channels + channel];
  }
};

/// κ and μ of every cube: the medium's mean over it.
std::vector<Coefficients> cube_coefficients(const CutMesh& mesh, const Octree& tree,
                                            const ObjectMedium& medium);
/// From coefficients [channel][cube].
Elements cube_elements(const CutMesh& mesh,
                       const std::vector<std::vector<Coefficients>>& coefficients, double A);

}  // namespace kappamu::forward::embedded
