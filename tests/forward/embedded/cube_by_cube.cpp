#include "cube_by_cube.h"

#include <cmath>

#include "core/error.h"
#include "core/numbers/dot.h"
#include "forward/embedded/equations/fields.h"

namespace kappamu::forward::embedded {

std::vector<double> reference_product(const NodeSpace& space, const Elements& elements,
                                      std::size_t channel, const std::vector<double>& x) {
  std::vector<double> product(x.size(), 0.0);
  for (std::size_t cube = 0; cube < space.cubes(); ++cube) {
    const std::array<double, 8> values = corner_values(space, cube, x);
    std::array<double, 8> image{};
    for (std::size_t i = 0; i < 8; ++i) {
      for (std::size_t j = 0; j < 8; ++j) image[i] += elements.of(cube, channel)(i, j) * values[j];
    }
    add_load(space, cube, image, product);
  }
  return product;
}

std::vector<double> reference_solution(const NodeSpace& space, const Elements& elements,
                                       std::size_t channel, const std::vector<double>& b,
                                       double tolerance) {
  std::vector<double> diagonal(b.size(), 0.0);
  for (std::size_t cube = 0; cube < space.cubes(); ++cube) {
    std::array<double, 8> own;
    for (std::size_t i = 0; i < 8; ++i) own[i] = elements.of(cube, channel)(i, i);
    add_load(space, cube, own, diagonal);
  }
  std::vector<double> x(b.size(), 0.0), r = b, z(b.size()), p(b.size(), 0.0);
  double r_z = 0.0;
  for (int iteration = 0; std::sqrt(dot(r, r)) > tolerance * std::sqrt(dot(b, b)); ++iteration) {
    check(iteration < 10'000, "the reference solver does not converge");
    for (std::size_t u = 0; u < b.size(); ++u) z[u] = diagonal[u] > 0.0 ? r[u] / diagonal[u] : 0.0;
    const double before = r_z;
    r_z = dot(r, z);
    for (std::size_t u = 0; u < b.size(); ++u) {
      p[u] = z[u] + (iteration > 0 ? r_z / before * p[u] : 0.0);
    }
    const std::vector<double> image = reference_product(space, elements, channel, p);
    const double step = r_z / dot(p, image);
    for (std::size_t u = 0; u < b.size(); ++u) {
      x[u] += step * p[u];
      r[u] -= step * image[u];
    }
  }
  return x;
}

}  // namespace kappamu::forward::embedded
