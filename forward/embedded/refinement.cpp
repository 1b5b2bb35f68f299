#include "forward/embedded/refinement.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"

namespace kappamu::forward::embedded {

namespace {

/// |∫ n dA| / ∫ dA is 1 on a plane, 0.58 about a cube's corner, 0 between a sheet's two sides.
constexpr double folded = 0.5;
/// What a split makes of a cube at the surface, and of one inside, where the error falls with h².
struct Split {
  double kept;   ///< of its share of the error, measured (embedded.md)
  double cubes;  ///< in its place
};
constexpr Split at_surface{0.45, 4.0};
constexpr Split inside{0.25, 8.0};
/// Further ahead the first estimate does not see.
constexpr double most_splits = 4.0;

/// Mean over the cube of the gradient of the trilinear function [1/mm].
Eigen::Vector3d mean_gradient(const std::array<double, 8>& values, double h) {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gradient[static_cast<Eigen::Index>(axis)] +=
          ((i >> axis & 1) != 0 ? 1.0 : -1.0) * values[i] / (4.0 * h);
    }
  }
  return gradient;
}

/// ∫ κ |∇φ − mean ∇φ|² dV over the cubes [begin, end).
double gradient_variation(const Discretisation& d, std::size_t channel,
                          const std::vector<double>& field, std::size_t begin, std::size_t end) {
  double weight = 0.0, squares = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = begin; k < end; ++k) {
    const double h = d.mesh.h(k);
    const double share = d.coefficients[channel][k].kappa * h * h * h * d.mesh.fraction(k);
    const Eigen::Vector3d gradient = mean_gradient(corner_values(d.space(), k, field), h);
    weight += share;
    sum += share * gradient;
    squares += share * gradient.squaredNorm();
  }
  return weight > 0.0 ? std::max(0.0, squares - sum.squaredNorm() / weight) : 0.0;
}

}  // namespace

std::vector<int> folds(const CutMesh& mesh, const Surface& surface) {
  std::vector<int> found;
  for (std::size_t k = 0; k < mesh.pieces.size();) {
    const int cube = mesh.pieces[k].cube;
    double area = 0.0;                                 // ∫ dA
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // ∫ n dA
    for (; k < mesh.pieces.size() && mesh.pieces[k].cube == cube; ++k) {
      const CutMesh::Piece& piece = mesh.pieces[k];
      const double weight = std::accumulate(piece.weight.begin(), piece.weight.end(), 0.0);
      area += weight;
      normal += weight * surface.normal[static_cast<std::size_t>(piece.triangle)];
    }
    if (normal.norm() < folded * area) found.push_back(mesh.leaf[static_cast<std::size_t>(cube)]);
  }
  return found;
}

Indicator gradient_indicator(const Discretisation& d, const std::vector<Answer>& channels,
                             bool weighs_last) {
  // Cubes of one parent follow each other.
  Indicator result;
  std::vector<std::size_t> first;
  for (std::size_t k = 0; k < d.mesh.cubes.size(); ++k) {
    const int parent = d.tree.parent(d.mesh.leaf[k]);
    if (!result.node.empty() && result.node.back() == parent) continue;
    result.node.push_back(parent);
    first.push_back(k);
  }
  first.push_back(d.mesh.cubes.size());
  for (std::size_t n = 0; n < result.node.size(); ++n) {
    result.cubes.push_back(static_cast<double>(first[n + 1] - first[n]));
    result.at_surface.push_back(d.tree.meets_surface(result.node[n]) ? 1 : 0);
  }
  result.value.assign(result.node.size(), 0.0);
  std::vector<double> mine(result.node.size()), weight;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto vary = [&](const std::vector<double>& field, std::vector<double>& energy) {
      for_ranges(energy.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n)
          energy[n] = gradient_variation(d, c, field, first[n], first[n + 1]);
      });
    };
    std::span<const std::vector<double>> fields = channels[c].fluence;
    if (weighs_last) {
      weight.resize(mine.size());
      vary(fields.back(), weight);
      fields = fields.first(fields.size() - 1);
    }
    for (const std::vector<double>& field : fields) {
      vary(field, mine);
      for (std::size_t n = 0; n < weight.size(); ++n) mine[n] = std::sqrt(mine[n] * weight[n]);
      const double total = std::accumulate(mine.begin(), mine.end(), 0.0);
      for (std::size_t n = 0; n < mine.size() && total > 0.0; ++n) {
        result.value[n] += mine[n] / total;
      }
    }
  }
  return result;
}

std::vector<int> splits(const Indicator& indicator, double left, std::size_t most_cubes) {
  // A cube is split while its share of the error, per cube that it became, exceeds `least`.
  const auto times = [&](std::size_t n, double least) {
    const Split& split = indicator.at_surface[n] != 0 ? at_surface : inside;
    const double over = std::log(indicator.value[n] / least) / std::log(split.cubes / split.kept);
    return over > 0.0 ? static_cast<int>(std::min(most_splits, std::ceil(over))) : 0;
  };
  const auto enough = [&](double least) {
    double sum = 0.0, before = 0.0, cubes = 0.0;
    for (std::size_t n = 0; n < indicator.value.size(); ++n) {
      const Split& split = indicator.at_surface[n] != 0 ? at_surface : inside;
      const int k = times(n, least);
      before += indicator.value[n];
      sum += indicator.value[n] * std::pow(split.kept, k);
      cubes += indicator.cubes[n] * std::pow(8.0, k);
    }
    return sum <= left * before || cubes > static_cast<double>(most_cubes);
  };
  double high = *std::max_element(indicator.value.begin(), indicator.value.end());
  double low = 1e-12 * high;
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = std::sqrt(low * high);
    (enough(middle) ? low : high) = middle;
  }
  std::vector<int> result;
  for (std::size_t n = 0; n < indicator.value.size(); ++n) result.push_back(times(n, low));
  return result;
}

}  // namespace kappamu::forward::embedded
