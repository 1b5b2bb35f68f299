#include "forward/embedded/hierarchy.h"

#include <cmath>
#include <map>

#include "core/error.h"

namespace kappamu::forward::embedded {

namespace {

/// At most this many unknowns are solved for directly.
constexpr std::size_t direct_unknowns = 300;

/// Unknowns whose scale is below this share of the largest belong to vanishing cut cubes alone. Their
/// equations weigh nothing; their values are what coarser levels interpolate.
constexpr double vanishing = 1e-14;

/// Rows filled from parts that are made independently.
template <class Row, class Fill>
SparseRows<double> make_rows(std::size_t rows, const Fill& fill) {
  constexpr std::size_t range = 4096;
  const std::size_t parts = (rows + range - 1) / range;
  std::vector<SparseRows<double>> part(parts);
  for_rows(static_cast<int>(parts), [&](int p) {
    SparseRows<double>& mine = part[static_cast<std::size_t>(p)];
    const std::size_t begin = static_cast<std::size_t>(p) * range;
    Row row;
    for (std::size_t i = begin; i < std::min(rows, begin + range); ++i) {
      row.clear();
      fill(i, row);
      for (const auto& [column, value] : row.entries()) {
        mine.column.push_back(column);
        mine.value.push_back(value);
      }
      mine.start.push_back(mine.column.size());
    }
  });
  SparseRows<double> all;
  for (const SparseRows<double>& mine : part) {
    const std::size_t before = all.column.size();
    for (std::size_t i = 1; i < mine.start.size(); ++i) all.start.push_back(before + mine.start[i]);
    all.column.insert(all.column.end(), mine.column.begin(), mine.column.end());
    all.value.insert(all.value.end(), mine.value.begin(), mine.value.end());
  }
  return all;
}

/// A row under construction: some tens of entries.
class RowSum {
 public:
  void clear() { entries_.clear(); }
  void add(int column, double value) {
    for (auto& entry : entries_) {
      if (entry.first == column) {
        entry.second += value;
        return;
      }
    }
    entries_.emplace_back(column, value);
  }
  const std::vector<std::pair<int, double>>& entries() const { return entries_; }

 private:
  std::vector<std::pair<int, double>> entries_;
};

/// For every unknown the cube corners that it has a part in.
struct Incidence {
  std::vector<std::size_t> start;
  std::vector<std::size_t> slot;  ///< 8·cube + corner
  explicit Incidence(const NodeSpace& space) : start(space.unknowns() + 1, 0) {
    const auto for_parts = [&](const auto& use) {
      for (std::size_t k = 0; k < space.cubes(); ++k) {
        for (std::size_t i = 0; i < 8; ++i) {
          for (const int u : space.parts(k, i)) use(static_cast<std::size_t>(u), 8 * k + i);
        }
      }
    };
    for_parts([&](std::size_t u, std::size_t) { ++start[u + 1]; });
    for (std::size_t u = 0; u + 1 < start.size(); ++u) start[u + 1] += start[u];
    slot.resize(start.back());
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    for_parts([&](std::size_t u, std::size_t s) { slot[next[u]++] = s; });
  }
};

struct Assembled {
  SparseRows<double> matrix;
  std::vector<float> inverse_scale;
};

Assembled assemble(const NodeSpace& space, const Elements& elements) {
  const Incidence incidence(space);
  std::vector<double> bound(elements.element.size());
  for_row_ranges(bound.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) bound[e] = scaled_bound(elements.element[e]);
  });
  Assembled result;
  std::vector<double> scales(space.unknowns());
  result.matrix = make_rows<RowSum>(space.unknowns(), [&](std::size_t u, RowSum& row) {
    double scale = 0.0;
    for (std::size_t s = incidence.start[u]; s < incidence.start[u + 1]; ++s) {
      const std::size_t cube = incidence.slot[s] / 8, i = incidence.slot[s] % 8;
      const double weight = NodeSpace::weight(space.parts(cube, i));
      const Element& element = elements.of(cube);
      // A cube's xᵀ a x ≤ λ Σ_i a_ii x_i², and a hanging x_i² ≤ Σ weight · x_part².
      scale += weight * bound[static_cast<std::size_t>(elements.of_cube[cube])] * element[9 * i];
      for (std::size_t j = 0; j < 8; ++j) {
        const auto parts = space.parts(cube, j);
        const double value = weight * NodeSpace::weight(parts) * element[8 * i + j];
        for (const int column : parts) row.add(column, value);
      }
    }
    scales[u] = scale;
  });
  const double least = vanishing * *std::max_element(scales.begin(), scales.end());
  for (const double scale : scales) {
    result.inverse_scale.push_back(scale > least ? static_cast<float>(1.0 / scale) : 0.0F);
  }
  return result;
}

SparseRows<float> rounded(const SparseRows<double>& matrix) {
  SparseRows<float> result;
  result.start = matrix.start;
  result.column = matrix.column;
  result.value.assign(matrix.value.begin(), matrix.value.end());
  return result;
}

/// Cubes, and for each cube of the finer list where it went.
struct Coarser {
  std::vector<Cube> cubes;
  std::vector<int> parent;  ///< per finer cube: cube here
  std::vector<int> octant;  ///< of the parent; −1 where the cube stays
};

Coarser coarsened(const std::vector<Cube>& fine) {
  int finest = 0;
  for (const Cube& cube : fine) finest = std::max(finest, cube.level);
  Coarser result;
  for (const Cube& cube : fine) {
    if (cube.level < finest) {
      result.octant.push_back(-1);
      result.cubes.push_back(cube);
    } else {
      const Cube parent{finest - 1, {cube.at[0] / 2, cube.at[1] / 2, cube.at[2] / 2}};
      result.octant.push_back(static_cast<int>((cube.at[0] & 1U) | (cube.at[1] & 1U) << 1U |
                                               (cube.at[2] & 1U) << 2U));
      // Morton order: siblings follow each other.
      if (result.cubes.empty() || result.cubes.back().level != parent.level ||
          result.cubes.back().at != parent.at) {
        result.cubes.push_back(parent);
      }
    }
    result.parent.push_back(static_cast<int>(result.cubes.size()) - 1);
  }
  return result;
}

Elements coarsened(const Elements& fine, const Coarser& coarser) {
  Elements result;
  result.of_cube.assign(coarser.cubes.size(), -1);
  std::map<int, int> kept, doubled;  // equal children make equal parents
  for (std::size_t k = 0; k < coarser.parent.size();) {
    const int parent = coarser.parent[k];
    std::size_t end = k;
    while (end < coarser.parent.size() && coarser.parent[end] == parent) ++end;
    const int first = fine.of_cube[k];
    const bool stays = coarser.octant[k] < 0;
    bool equal = stays || end - k == 8;
    for (std::size_t child = k; child < end; ++child) {
      equal = equal && fine.of_cube[child] == first;
    }
    int made = static_cast<int>(result.element.size());
    if (equal) made = (stays ? kept : doubled).try_emplace(first, made).first->second;
    result.of_cube[static_cast<std::size_t>(parent)] = made;
    if (made == static_cast<int>(result.element.size())) {
      Element sum{};
      for (std::size_t child = k; child < end; ++child) {
        if (stays) {
          sum = fine.of(child);
        } else {
          add_child(sum, fine.of(child), coarser.octant[child]);
        }
      }
      result.element.push_back(sum);
    }
    k = end;
  }
  return result;
}

/// Values of coarse functions at the fine unknowns.
SparseRows<double> interpolation(const NodeSpace& fine, const NodeSpace& coarse,
                                 const Coarser& coarser) {
  std::vector<std::size_t> slot(fine.unknowns());  // a cube corner that is the unknown
  for (std::size_t k = 0; k < fine.cubes(); ++k) {
    for (std::size_t i = 0; i < 8; ++i) {
      const auto parts = fine.parts(k, i);
      if (parts.size() == 1) slot[static_cast<std::size_t>(parts[0])] = 8 * k + i;
    }
  }
  return make_rows<RowSum>(fine.unknowns(), [&](std::size_t u, RowSum& row) {
    const std::size_t k = slot[u] / 8, i = slot[u] % 8;
    const auto parent = static_cast<std::size_t>(coarser.parent[k]);
    for (std::size_t j = 0; j < 8; ++j) {
      const double weight = coarser.octant[k] < 0 ? (i == j ? 1.0 : 0.0)
                                                  : parent_weight(coarser.octant[k], static_cast<int>(i),
                                                                  static_cast<int>(j));
      if (weight == 0.0) continue;
      const auto parts = coarse.parts(parent, j);
      for (const int column : parts) row.add(column, weight * NodeSpace::weight(parts));
    }
  });
}

Eigen::MatrixXd dense(const SparseRows<double>& matrix) {
  const auto size = static_cast<Eigen::Index>(matrix.rows());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t row = 0; row < matrix.rows(); ++row) {
    for (std::size_t k = matrix.start[row]; k < matrix.start[row + 1]; ++k) {
      result(static_cast<Eigen::Index>(row), matrix.column[k]) = matrix.value[k];
    }
  }
  // Unknowns that only a vanishing cut cube has: rounding must not make them indefinite.
  for (double& own : result.diagonal()) own = own > 0.0 ? own * (1.0 + 1e-12) : 1.0;
  return result;
}

}  // namespace

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
      result.element[static_cast<std::size_t>(result.of_cube[k])] = cut_element(
          coefficients[k], mesh.h(k), mesh.volume[moments], mesh.surface[moments], A);
    }
  });
  return result;
}

Hierarchy make_hierarchy(const CutMesh& mesh, Elements elements) {
  Hierarchy result;
  std::vector<Cube> cubes = mesh.cubes;
  result.space = NodeSpace(cubes);
  NodeSpace space = result.space;
  for (;;) {
    Assembled assembled = assemble(space, elements);
    Level level;
    level.matrix = rounded(assembled.matrix);
    level.inverse_scale = std::move(assembled.inverse_scale);
    const bool coarsest = space.unknowns() <= direct_unknowns || cubes.size() == 1;
    if (coarsest) result.coarsest.compute(dense(assembled.matrix));
    if (result.levels.empty()) result.matrix = std::move(assembled.matrix);
    if (!coarsest) {
      const Coarser coarser = coarsened(cubes);
      NodeSpace coarse_space(coarser.cubes);
      level.interpolation = rounded(interpolation(space, coarse_space, coarser));
      level.restriction = transposed(level.interpolation, coarse_space.unknowns());
      elements = coarsened(elements, coarser);
      cubes = coarser.cubes;
      space = std::move(coarse_space);
    }
    result.levels.push_back(std::move(level));
    if (coarsest) break;
  }
  check(result.coarsest.info() == Eigen::Success, "the coarsest matrix is not positive definite");
  return result;
}

}  // namespace kappamu::forward::embedded
