#include "forward/embedded/equations/fields.h"

namespace kappamu::forward::embedded {

std::array<double, 8> corner_values(const NodeSpace& space, std::size_t cube,
                                    const std::vector<double>& field) {
  std::array<double, 8> values;
  for (std::size_t i = 0; i < 8; ++i) {
    const auto parts = space.parts(cube, i);
    double sum = 0.0;
    for (const int u : parts) sum += field[static_cast<std::size_t>(u)];
    values[i] = NodeSpace::weight(parts) * sum;
  }
  return values;
}

void add_load(const NodeSpace& space, std::size_t cube, const std::array<double, 8>& power,
              std::vector<double>& load) {
  for (std::size_t i = 0; i < 8; ++i) {
    const auto parts = space.parts(cube, i);
    for (const int u : parts) {
      load[static_cast<std::size_t>(u)] += NodeSpace::weight(parts) * power[i];
    }
  }
}

void add_surface_load(const CutMesh& mesh, const NodeSpace& space, const std::vector<double>& flux,
                      std::vector<double>& load) {
  for (const CutMesh::Piece& piece : mesh.pieces) {
    std::array<double, 8> power;
    for (std::size_t i = 0; i < 8; ++i) {
      power[i] =
          static_cast<double>(piece.weight[i]) * flux[static_cast<std::size_t>(piece.triangle)];
    }
    add_load(space, static_cast<std::size_t>(piece.cube), power, load);
  }
}

std::vector<double> triangle_means(const CutMesh& mesh, const NodeSpace& space,
                                   const std::vector<double>& field, std::size_t triangles) {
  std::vector<double> integral(triangles, 0.0), area(triangles, 0.0);
  std::array<double, 8> values{};
  for (std::size_t k = 0; k < mesh.pieces.size(); ++k) {
    const CutMesh::Piece& piece = mesh.pieces[k];
    if (k == 0 || mesh.pieces[k - 1].cube != piece.cube) {
      values = corner_values(space, static_cast<std::size_t>(piece.cube), field);
    }
    const auto triangle = static_cast<std::size_t>(piece.triangle);
    for (std::size_t i = 0; i < 8; ++i) {
      const double weight = static_cast<double>(piece.weight[i]);
      integral[triangle] += weight * values[i];
      area[triangle] += weight;
    }
  }
  for (std::size_t t = 0; t < triangles; ++t) {
    if (area[t] > 0.0) integral[t] /= area[t];
  }
  return integral;
}

double absorbed_power(const CutMesh& mesh, const NodeSpace& space,
                      const std::vector<Coefficients>& coefficients,
                      const std::vector<double>& field) {
  double total = 0.0;
  for (std::size_t k = 0; k < mesh.cubes.size(); ++k) {
    const std::array<double, 8> values = corner_values(space, k, field);
    double mean = 0.0;  // over the part inside, times its share of the cube
    if (mesh.cut[k] < 0) {
      for (const double value : values) mean += value / 8.0;
    } else {
      // Coefficients of 1, x, y, xy, z, … of the trilinear function from its corner values.
      std::array<double, 8> c = values;
      for (std::size_t bit = 1; bit < 8; bit *= 2) {
        for (std::size_t i = 0; i < 8; ++i) {
          if ((i & bit) != 0) c[i] -= c[i ^ bit];
        }
      }
      const Moments& moments = mesh.volume[static_cast<std::size_t>(mesh.cut[k])];
      for (std::size_t i = 0; i < 8; ++i) {
        mean += c[i] * moments[(i & 1) + 3 * (i >> 1 & 1) + 9 * (i >> 2 & 1)];
      }
    }
    const double h = mesh.h(k);
    total += coefficients[k].mu * h * h * h * mean;
  }
  return total;
}

}  // namespace kappamu::forward::embedded
