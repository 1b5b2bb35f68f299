#include "forward/embedded/equations/cube_elements.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/parallel.h"

namespace kappamu::forward::embedded {

std::vector<Coefficients> cube_coefficients(const CutMesh& mesh, const Octree& tree,
                                            const ObjectMedium& medium) {
  std::vector<Coefficients> result(mesh.cubes.size(), medium.smallest());
  if (medium.homogeneous()) return result;
  for_ranges(result.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Cube& cube = mesh.cubes[k];
      const int samples =
          std::clamp(static_cast<int>(std::ceil(2.0 * mesh.h(k) / *medium.voxel_mm())), 2, 4);
      Coefficients sum;
      for (int s = 0; s < samples * samples * samples; ++s) {
        const Eigen::Vector3d in_cube(s % samples + 0.5, s / samples % samples + 0.5,
                                      s / (samples * samples) + 0.5);
        const Eigen::Vector3d at =
            Eigen::Vector3d(cube.at[0], cube.at[1], cube.at[2]) + in_cube / samples;
        const Coefficients here = medium.at(tree.to_mm(std::ldexp(1.0, -cube.level) * at));
        sum.kappa += here.kappa;
        sum.mu += here.mu;
      }
      const double count = samples * samples * samples;
      result[k] = {sum.kappa / count, sum.mu / count};
    }
  });
  return result;
}

Elements cube_elements(const CutMesh& mesh,
                       const std::vector<std::vector<Coefficients>>& coefficients, double A) {
  Elements result;
  result.channels = coefficients.size();
  result.of_cube.resize(mesh.cubes.size());
  std::map<std::vector<double>, int> whole;  // by h and every channel's κ and μ
  std::vector<std::size_t> first;            // cube of each place
  std::vector<double> key;
  for (std::size_t k = 0; k < mesh.cubes.size(); ++k) {
    const int next = static_cast<int>(first.size());
    result.of_cube[k] = next;
    if (mesh.cut[k] < 0) {
      key.assign(1, mesh.h(k));
      for (const std::vector<Coefficients>& channel : coefficients) {
        key.push_back(channel[k].kappa);
        key.push_back(channel[k].mu);
      }
      const auto [place, made] = whole.try_emplace(key, next);
      result.of_cube[k] = place->second;
      if (!made) continue;
    }
    first.push_back(k);
  }
  result.element.resize(first.size() * result.channels);
  for_ranges(first.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t place = begin; place < end; ++place) {
      const std::size_t k = first[place];
      const auto cut = static_cast<std::size_t>(mesh.cut[k]);
      const ElementIntegrals integrals =
          mesh.cut[k] < 0 ? whole_integrals()
                          : element_integrals(mesh.volume[cut], mesh.surface[cut]);
      for (std::size_t c = 0; c < result.channels; ++c) {
        result.element[place * result.channels + c] =
            element_of(integrals, coefficients[c][k], mesh.h(k), A);
      }
    }
  });
  return result;
}

}  // namespace kappamu::forward::embedded
