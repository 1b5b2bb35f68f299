#include "forward/embedded/equations/levels.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>

#include "core/numbers/linear_algebra.h"
#include "core/parallel.h"

namespace kappamu::forward::embedded {

namespace {

/// At most this many unknowns are solved for directly.
constexpr std::size_t direct_unknowns = 300;

/// Unknowns whose scale is below this share of the largest belong to vanishing cut cubes alone.
/// Their equations weigh nothing; their values are what coarser levels interpolate.
constexpr double vanishing = 1e-14;

std::vector<std::vector<float>> inverse_scales(const NodeSpace& space, const Elements& elements) {
  std::vector<double> bound(elements.element.size());
  for_ranges(bound.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) bound[e] = scaled_bound(elements.element[e]);
  });
  std::vector<std::vector<float>> result(elements.channels);
  for_rows(static_cast<int>(elements.channels), [&](int channel) {
    const auto c = static_cast<std::size_t>(channel);
    std::vector<double> scale(space.unknowns(), 0.0);
    for (std::size_t k = 0; k < space.cubes(); ++k) {
      const std::size_t place =
          static_cast<std::size_t>(elements.of_cube[k]) * elements.channels + c;
      for (std::size_t i = 0; i < 8; ++i) {
        // A cube's xᵀ a x ≤ λ Σ_i a_ii x_i², and a hanging x_i² ≤ Σ weight · x_part².
        const double own = bound[place] * elements.element[place](i, i);
        const auto parts = space.parts(k, i);
        for (const int u : parts) {
          scale[static_cast<std::size_t>(u)] += NodeSpace::weight(parts) * own;
        }
      }
    }
    const double least = vanishing * *std::max_element(scale.begin(), scale.end());
    result[c].reserve(scale.size());
    for (const double d : scale) {
      result[c].push_back(d > least ? static_cast<float>(1.0 / d) : 0.0F);
    }
  });
  return result;
}

Cube parent_of(const Cube& cube) {
  return {cube.level - 1, {cube.at[0] / 2, cube.at[1] / 2, cube.at[2] / 2}};
}

/// Whether the parent of the larger of two cubes holds the other too.
bool split_unevenly(const Cube& one, const Cube& other) {
  if (one.level == other.level) return false;
  const Cube& small = one.level > other.level ? one : other;
  const Cube parent = parent_of(one.level > other.level ? other : one);
  const int below = small.level - parent.level;
  return small.at[0] >> below == parent.at[0] && small.at[1] >> below == parent.at[1] &&
         small.at[2] >> below == parent.at[2];
}

/// The cubes of the coarser level, and where each cube of the finer went.
std::vector<Cube> coarsened(const std::vector<Cube>& fine, Coarser& coarser) {
  int least = 1;  // of the levels whose cubes are replaced
  for (std::size_t k = 1; k < fine.size() && least == 1; ++k) {
    // Morton order: where siblings are of different levels, two of them follow each other.
    if (split_unevenly(fine[k - 1], fine[k])) {
      for (const Cube& cube : fine) least = std::max(least, cube.level);
    }
  }
  std::vector<Cube> coarse;
  for (const Cube& cube : fine) {
    if (cube.level < least) {
      coarser.octant.push_back(-1);
      coarse.push_back(cube);
    } else {
      const Cube parent = parent_of(cube);
      coarser.octant.push_back(
          static_cast<int>((cube.at[0] & 1U) | (cube.at[1] & 1U) << 1U | (cube.at[2] & 1U) << 2U));
      // Morton order: siblings follow each other.
      if (coarse.empty() || coarse.back().level != parent.level || coarse.back().at != parent.at) {
        coarse.push_back(parent);
      }
    }
    coarser.parent.push_back(static_cast<int>(coarse.size()) - 1);
  }
  return coarse;
}

Elements coarsened(const Elements& fine, const Coarser& coarser, std::size_t cubes) {
  Elements result;
  result.channels = fine.channels;
  result.of_cube.assign(cubes, -1);
  std::map<int, int> kept, doubled;  // equal children make equal parents
  struct Sum {
    std::size_t first, end;  ///< children of one place
  };
  std::vector<Sum> sums;
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
    int made = static_cast<int>(sums.size());
    if (equal) made = (stays ? kept : doubled).try_emplace(first, made).first->second;
    result.of_cube[static_cast<std::size_t>(parent)] = made;
    if (made == static_cast<int>(sums.size())) sums.push_back({k, end});
    k = end;
  }
  result.element.resize(sums.size() * result.channels);
  for_ranges(sums.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t place = begin; place < end; ++place) {
      for (std::size_t c = 0; c < result.channels; ++c) {
        Element& sum = result.element[place * result.channels + c];
        for (std::size_t child = sums[place].first; child < sums[place].end; ++child) {
          if (coarser.octant[child] < 0) {
            sum = fine.of(child, c);
          } else {
            add_child(sum, fine.of(child, c), coarser.octant[child]);
          }
        }
      }
    }
  });
  return result;
}

/// The inverse of the matrix, as D^½ A⁻¹ D^½ scaled back.
Eigen::MatrixXd inverse(const NodeSpace& space, const Elements& elements, std::size_t channel) {
  const auto size = static_cast<Eigen::Index>(space.unknowns());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t k = 0; k < space.cubes(); ++k) {
    for (std::size_t i = 0; i < 8; ++i) {
      for (std::size_t j = 0; j < 8; ++j) {
        const auto rows = space.parts(k, i), columns = space.parts(k, j);
        const double value =
            NodeSpace::weight(rows) * NodeSpace::weight(columns) * elements.of(k, channel)(i, j);
        for (const int row : rows) {
          for (const int column : columns) matrix(row, column) += value;
        }
      }
    }
  }
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  matrix = scale.asDiagonal() * matrix * scale.asDiagonal();
  matrix.diagonal().array() += 1e-12;  // vanishing cuts make nearly dependent unknowns
  const Eigen::MatrixXd scaled = inverse_definite(matrix);
  return scale.asDiagonal() * (0.5 * (scaled + scaled.transpose())) * scale.asDiagonal();
}

}  // namespace

Levels make_levels(const std::vector<Cube>& cubes, Elements elements) {
  Levels result;
  std::vector<Cube> here = cubes;
  for (;;) {
    Level level;
    level.space = NodeSpace(here);
    level.inverse_scale = inverse_scales(level.space, elements);
    const bool coarsest = level.space.unknowns() <= direct_unknowns || here.size() == 1;
    Elements next;
    if (coarsest) {
      for (std::size_t c = 0; c < elements.channels; ++c) {
        result.coarsest.push_back(inverse(level.space, elements, c));
      }
    } else {
      here = coarsened(here, level.coarser);
      next = coarsened(elements, level.coarser, here.size());
    }
    level.elements = std::move(elements);
    elements = std::move(next);
    result.level.push_back(std::move(level));
    if (coarsest) return result;
  }
}

std::vector<double> Transfer::restricted(const std::vector<double>& load) const {
  const NodeSpace& coarse = levels_.level[1].space;
  std::vector<double> result(coarse.unknowns(), 0.0);
  for (std::size_t u = 0; u < owner_.size(); ++u) {
    for_coarser_parts(levels_.level[0].coarser, coarse, owner_[u], [&](int part, double weight) {
      result[static_cast<std::size_t>(part)] += weight * load[u];
    });
  }
  return result;
}

std::vector<double> Transfer::prolonged(const std::vector<double>& field) const {
  std::vector<double> result(owner_.size(), 0.0);
  for (std::size_t u = 0; u < owner_.size(); ++u) {
    for_coarser_parts(levels_.level[0].coarser, levels_.level[1].space, owner_[u],
                      [&](int part, double weight) {
                        result[u] += weight * field[static_cast<std::size_t>(part)];
                      });
  }
  return result;
}

std::vector<int> owner_slots(const NodeSpace& space) {
  std::vector<int> slot(space.unknowns());
  for (std::size_t k = 0; k < space.cubes(); ++k) {
    for (std::size_t i = 0; i < 8; ++i) {
      const auto parts = space.parts(k, i);
      if (parts.size() == 1) slot[static_cast<std::size_t>(parts[0])] = static_cast<int>(8 * k + i);
    }
  }
  return slot;
}

Incidence::Incidence(const NodeSpace& space) : start(space.unknowns() + 1, 0) {
  const auto for_parts = [&](const auto& use) {
    for (std::size_t k = 0; k < space.cubes(); ++k) {
      for (std::size_t i = 0; i < 8; ++i) {
        for (const int u : space.parts(k, i)) use(static_cast<std::size_t>(u), 8 * k + i);
      }
    }
  };
  for_parts([&](std::size_t u, std::size_t) { ++start[u + 1]; });
  for (std::size_t u = 0; u + 1 < start.size(); ++u) start[u + 1] += start[u];
  slot.resize(static_cast<std::size_t>(start.back()));
  std::vector<int> next(start.begin(), start.end() - 1);
  for_parts([&](std::size_t u, std::size_t s) {
    slot[static_cast<std::size_t>(next[u]++)] = static_cast<int>(s);
  });
}

}  // namespace kappamu::forward::embedded
