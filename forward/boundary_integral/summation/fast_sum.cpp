#include "forward/boundary_integral/summation/fast_sum.h"

#include <algorithm>

#include "core/numbers/at.h"
#include "core/parallel.h"
#include "forward/boundary_integral/summation/box_pairs.h"
#include "forward/boundary_integral/summation/equivalent_surface.h"

namespace kappamu::forward::boundary_integral {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;

/// Target boxes that a thread translates at once.
constexpr int boxes_at_once = 64;

std::vector<Place> places(const SumElements& elements) {
  std::vector<Place> result;
  for (std::size_t k = 0; k < elements.centre.size(); ++k) {
    result.push_back({elements.centre[k], 0.0});
    for (int p = 0; p < elements.points; ++p) {
      const Eigen::Vector3d& point = elements.at[k * at(elements.points) + at(p)];
      result.back().reach = std::max(result.back().reach, (point - elements.centre[k]).norm());
    }
  }
  return result;
}

}  // namespace

class FastSum::Plan {
 public:
  Plan(SumSources sources, SumElements targets, NearValue near, const Options& options)
      : options_(options),
        per_source_(sources.points),
        per_target_(targets.points),
        near_value_(std::move(near)),
        tree_(make_octree(places(sources), places(targets), options.leaf)),
        pairs_(tree_, options.decay),
        surfaces_(options.order, options.decay) {
    sort_points(sources, targets);
    find_levels();
    for (int b = 0; b < boxes(); ++b) {
      if (box(b).leaf()) leaves_.push_back(b);
    }
    if (!kept()) return;
    outgoing_.resize(tree_.boxes.size());
    incoming_.resize(tree_.boxes.size());
    blocks_.resize(tree_.boxes.size());
    for_rows(static_cast<int>(leaves_.size()), [&](int k) {
      const int b = leaves_[at(k)];
      if (box(b).level >= top_) {
        outgoing_[at(b)] = outgoing(b);
        incoming_[at(b)] = incoming(b);
      }
      for (const int s : pairs_.near[at(b)]) blocks_[at(b)].push_back(block(b, s));
    });
  }

  VectorXd sum(const VectorXd& strength) const {
    VectorXd sorted(strength.size());
    for (Index k = 0; k < sorted.size(); ++k) {
      sorted[k] = strength[tree_.source[static_cast<std::size_t>(k)]];
    }
    const MatrixXd potentials = incoming_potentials(outgoing_charges(sorted));
    VectorXd result = VectorXd::Zero(static_cast<Index>(tree_.target.size()));
    for_rows(static_cast<int>(leaves_.size()), [&](int k) {
      const int b = leaves_[at(k)];
      const Box& target = box(b);
      if (target.targets() == 0) return;
      VectorXd value = VectorXd::Zero(target.targets());
      if (target.level >= top_) {
        value += (kept() ? incoming_[at(b)] : incoming(b)).cast<double>() * potentials.col(b);
      }
      for (std::size_t n = 0; n < pairs_.near[at(b)].size(); ++n) {
        const int s = pairs_.near[at(b)][n];
        const Eigen::VectorXf charge =
            sorted.segment(box(s).first_source, box(s).sources()).cast<float>();
        value += ((kept() ? blocks_[at(b)][n] : block(b, s)) * charge).cast<double>();
      }
      for (int t = 0; t < target.targets(); ++t) {
        result[tree_.target[at(target.first_target + t)]] = value[t];
      }
    });
    return result;
  }

  std::size_t bytes() const {
    Index floats = 0;
    for (const auto* kept : {&outgoing_, &incoming_}) {
      for (const MatrixXf& m : *kept) floats += m.size();
    }
    for (const auto& row : blocks_) {
      for (const MatrixXf& m : row) floats += m.size();
    }
    return sizeof(float) * static_cast<std::size_t>(floats);
  }

 private:
  const Box& box(int b) const { return tree_.boxes[at(b)]; }
  bool kept() const { return options_.keep == Keep::matrices; }
  int boxes() const { return static_cast<int>(tree_.boxes.size()); }

  void sort_points(const SumSources& sources, const SumElements& targets) {
    const auto rows = static_cast<Index>(sources.at.size());
    points_.at.resize(rows, 3);
    points_.dipole.resize(sources.dipole.empty() ? 0 : rows, 3);
    points_.charge.resize(rows);
    Index row = 0;
    for (const int element : tree_.source) {
      for (int p = 0; p < per_source_; ++p, ++row) {
        const std::size_t from = at(element * per_source_ + p);
        points_.at.row(row) = sources.at[from].transpose().array();
        points_.charge[row] = sources.charge[from];
        if (!sources.dipole.empty()) {
          points_.dipole.row(row) = sources.dipole[from].transpose().array();
        }
      }
    }
    for (const int element : tree_.target) {
      for (int p = 0; p < per_target_; ++p) {
        target_points_.push_back(targets.at[at(element * per_target_ + p)]);
      }
    }
  }

  void find_levels() {
    top_ = tree_.levels();
    for (int b = 0; b < boxes(); ++b) {
      if (!pairs_.far[at(b)].empty()) top_ = std::min(top_, box(b).level);
    }
    maps_.resize(at(tree_.levels()));
    for (int level = top_; level < tree_.levels(); ++level) {
      maps_[at(level)] = surfaces_.maps(tree_.width(level));
    }
  }

  /// (surface, sources): potentials on a leaf's outer cube of each source's unit strength.
  MatrixXf outgoing(int b) const {
    const Box& leaf = box(b);
    const Eigen::MatrixX3d outer = cube(leaf, outer_cube);
    MatrixXf result(outer.rows(), leaf.sources());
    for (Index k = 0; k < outer.rows(); ++k) {
      result.row(k) = element_sums(outer.row(k), leaf).cast<float>().transpose();
    }
    return result;
  }
  /// (targets, surface): potentials at a leaf's targets of each unit potential on its inner cube.
  MatrixXf incoming(int b) const {
    const Box& leaf = box(b);
    const Eigen::MatrixX3d outer = cube(leaf, outer_cube);
    MatrixXd from_charges = MatrixXd::Zero(leaf.targets(), outer.rows());
    for (int t = 0; t < leaf.targets(); ++t) {
      for (int p = 0; p < per_target_; ++p) {
        const Eigen::Vector3d& x = target_points_[at((leaf.first_target + t) * per_target_ + p)];
        const Eigen::ArrayXd r = (outer.rowwise() - x.transpose()).rowwise().norm().array();
        from_charges.row(t) += greens_function(r, options_.decay).matrix() / per_target_;
      }
    }
    return (from_charges * maps_[at(leaf.level)].charges_from_check.transpose()).cast<float>();
  }
  /// (targets, sources) of two leaves.
  MatrixXf block(int b, int s) const {
    const Box &target = box(b), &source = box(s);
    MatrixXf result(target.targets(), source.sources());
    for (int t = 0; t < target.targets(); ++t) {
      VectorXd row = VectorXd::Zero(source.sources());
      for (int p = 0; p < per_target_; ++p) {
        row +=
            element_sums(target_points_[at((target.first_target + t) * per_target_ + p)], source) /
            per_target_;
      }
      if (near_value_) {
        for (int k = 0; k < source.sources(); ++k) {
          const std::optional<double> own = near_value_(tree_.target[at(target.first_target + t)],
                                                        tree_.source[at(source.first_source + k)]);
          if (own) row[k] = *own;
        }
      }
      result.row(t) = row.cast<float>().transpose();
    }
    return result;
  }
  VectorXd element_sums(const Eigen::Vector3d& x, const Box& source) const {
    const Eigen::ArrayXd each =
        points_.potentials(x, Index{per_source_} * source.first_source,
                           Index{per_source_} * source.end_source, options_.decay);
    if (per_source_ == 1) return each;
    return each.reshaped(per_source_, source.sources()).colwise().sum().transpose();
  }
  Eigen::MatrixX3d cube(const Box& leaf, double size) const {
    return surfaces_.lattice().points(0.5 * size * tree_.width(leaf.level)).rowwise() +
           tree_.centre(leaf).transpose();
  }

  /// (surface, box): charges on the inner cubes.
  MatrixXd outgoing_charges(const VectorXd& sorted) const {
    MatrixXd charges = MatrixXd::Zero(surfaces_.lattice().size(), boxes());
    for (int level = tree_.levels() - 1; level >= top_; --level) {
      const LevelMaps& maps = maps_[at(level)];
      const int begin = tree_.level_begin[at(level)];
      for_rows(tree_.level_begin[at(level) + 1] - begin, [&](int k) {
        const int b = begin + k;
        const Box& here = box(b);
        if (here.sources() == 0) return;
        if (here.leaf()) {
          const VectorXd check = (kept() ? outgoing_[at(b)] : outgoing(b)).cast<double>() *
                                 sorted.segment(here.first_source, here.sources());
          charges.col(b) = maps.charges_from_check * check;
        } else {
          for (std::size_t o = 0; o < 8; ++o) {
            if (here.child[o] >= 0) {
              charges.col(b) += maps.parent_from_child[o] * charges.col(here.child[o]);
            }
          }
        }
      });
    }
    return charges;
  }

  /// (surface, box): potentials on the inner cubes of all that is far.
  MatrixXd incoming_potentials(const MatrixXd& charges) const {
    MatrixXd potentials = MatrixXd::Zero(charges.rows(), boxes());
    for (int level = top_; level < tree_.levels(); ++level) {
      const int begin = tree_.level_begin[at(level)], end = tree_.level_begin[at(level) + 1];
      for_rows((end - begin + boxes_at_once - 1) / boxes_at_once, [&](int k) {
        translate(level, begin + k * boxes_at_once, std::min(end, begin + (k + 1) * boxes_at_once),
                  charges, potentials);
      });
      if (level + 1 == tree_.levels()) break;
      for_rows(end - begin, [&](int k) {
        const Box& parent = box(begin + k);
        for (std::size_t o = 0; o < 8; ++o) {
          if (parent.child[o] < 0) continue;
          potentials.col(parent.child[o]).noalias() +=
              maps_[at(level)].parent_from_child[o].transpose() * potentials.col(begin + k);
        }
      });
    }
    return potentials;
  }

  /// Boxes [begin, end) receive from far boxes of their level, all of one kind in one product.
  void translate(int level, int begin, int end, const MatrixXd& charges,
                 MatrixXd& potentials) const {
    for (const auto& [kind, matrix] : maps_[at(level)].translation) {
      std::vector<std::pair<int, const FarBox*>> pairs;
      for (int b = begin; b < end; ++b) {
        for (const FarBox& far : pairs_.far[at(b)]) {
          if (far.translation.kind == kind) pairs.emplace_back(b, &far);
        }
      }
      if (pairs.empty()) continue;
      const auto columns = static_cast<Index>(pairs.size());
      MatrixXd from(charges.rows(), columns);
      for (Index c = 0; c < columns; ++c) {
        const FarBox& far = *pairs[static_cast<std::size_t>(c)].second;
        const std::vector<int>& to = surfaces_.symmetry(far.translation.symmetry);
        for (Index n = 0; n < charges.rows(); ++n) {
          from(to[static_cast<std::size_t>(n)], c) = charges(n, far.source);
        }
      }
      const MatrixXd received = matrix * from;
      for (Index c = 0; c < columns; ++c) {
        const auto& [b, far] = pairs[static_cast<std::size_t>(c)];
        const std::vector<int>& to = surfaces_.symmetry(far->translation.symmetry);
        for (Index n = 0; n < charges.rows(); ++n) {
          potentials(n, b) += received(to[static_cast<std::size_t>(n)], c);
        }
      }
    }
  }

  Options options_;
  int per_source_, per_target_;
  NearValue near_value_;
  Octree tree_;
  BoxPairs pairs_;
  EquivalentSurfaces surfaces_;
  PointSources points_;                         ///< in the tree's order
  std::vector<Eigen::Vector3d> target_points_;  ///< in the tree's order
  std::vector<int> leaves_;
  int top_ = 0;  ///< the coarsest level that exchanges far fields
  std::vector<LevelMaps> maps_;
  std::vector<MatrixXf> outgoing_, incoming_;
  std::vector<std::vector<MatrixXf>> blocks_;
};

int sum_order(double accuracy) {
  return accuracy >= 1e-4 ? 4 : accuracy >= 1e-5 ? 5 : accuracy >= 1e-6 ? 6 : 7;
}

FastSum::FastSum(SumSources sources, SumElements targets, NearValue near, const Options& options)
    : plan_(std::make_unique<Plan>(std::move(sources), std::move(targets), std::move(near),
                                   options)) {}
FastSum::~FastSum() = default;
FastSum::FastSum(FastSum&&) noexcept = default;

VectorXd FastSum::operator()(const VectorXd& strength) const {
  return plan_->sum(strength);
}

std::size_t FastSum::bytes() const {
  return plan_->bytes();
}

}  // namespace kappamu::forward::boundary_integral
