#include "forward/embedded/cube_elements.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "forward/embedded/sparse_rows.h"

namespace kappamu::forward::embedded {

std::vector<Coefficients> cube_coefficients(const CutMesh& mesh, const Octree& tree,
                                            const ObjectMedium& medium) {
  std::vector<Coefficients> result(mesh.cubes.size(), medium.smallest());
  if (medium.homogeneous()) return result;
  for_row_ranges(result.size(), [&](std::size_t begin, std::size_t end) {
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

Elements cube_elements(const CutMesh& mesh, const std::vector<Coefficients>& coefficients,
                       double A) {
  Elements result;
  result.of_cube.resize(mesh.cubes.size());
  std::map<std::array<double, 3>, int> whole;  // by κ, μ, h
  std::vector<std::size_t> cut;
  for (std::size_t k = 0; k < mesh.cubes.size(); ++k) {
    const auto next = static_cast<int>(result.element.size());
    if (mesh.cut[k] >= 0) {
      result.of_cube[k] = next;
      result.element.emplace_back();
      cut.push_back(k);
      continue;
    }
    const double h = mesh.h(k);
    const auto [place, made] =
        whole.try_emplace({coefficients[k].kappa, coefficients[k].mu, h}, next);
    result.of_cube[k] = place->second;
    if (made) result.element.push_back(whole_element(coefficients[k], h));
  }
  for_row_ranges(cut.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const std::size_t k = cut[c];
      const auto moments = static_cast<std::size_t>(mesh.cut[k]);
      result.element[static_cast<std::size_t>(result.of_cube[k])] =
          cut_element(coefficients[k], mesh.h(k), mesh.volume[moments], mesh.surface[moments], A);
    }
  });
  return result;
}

}  // namespace kappamu::forward::embedded
