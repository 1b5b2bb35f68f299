#include "forward/dipole/hierarchy/links.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace kappamu::forward::dipole {

namespace {

/// Receivers below clusters of this level are linked independently of each other.
constexpr int pair_task_level = 6;

/// Links of the receivers that one thread visits.
class Linker {
 public:
  Linker(const ClusterTree& tree, const Oracle& oracle, Links& links)
      : tree_(tree), oracle_(oracle), links_(links) {}

  std::vector<int> emitter, near;

  /// Links `receiver`, and returns the emitters that its children must meet.
  void meet(std::size_t receiver, const std::vector<int>& candidates, std::vector<int>& rest) {
    LinkRange& range = links_.of_cluster[receiver];
    range.first = static_cast<int>(emitter.size());
    const bool leaf = tree_.leaf(receiver);
    const std::size_t near_first = near.size();
    const Eigen::Array4f& here = tree_.cluster()[receiver];
    stack_.assign(candidates.rbegin(), candidates.rend());
    while (!stack_.empty()) {
      const int e = stack_.back();
      stack_.pop_back();
      const auto k = static_cast<std::size_t>(e);
      const Eigen::Array4f& there = tree_.cluster()[k];
      if (oracle_.holds(here, there)) {
        emitter.push_back(e);
      } else if (!tree_.leaf(k) && (leaf || there[3] > here[3])) {
        stack_.push_back(2 * e + 2);
        stack_.push_back(2 * e + 1);
      } else if (leaf) {
        near.push_back(e - static_cast<int>(tree_.first_leaf()));
      } else {
        rest.push_back(e);
      }
    }
    range.count = static_cast<int>(emitter.size()) - range.first;
    if (leaf) {
      links_.of_leaf[receiver - tree_.first_leaf()] = {static_cast<int>(near_first),
                                                       static_cast<int>(near.size() - near_first)};
    }
  }

  void meet_all_below(std::size_t receiver, const std::vector<int>& candidates, int level) {
    const auto l = static_cast<std::size_t>(level);
    if (rest_.size() <= l) rest_.resize(static_cast<std::size_t>(tree_.depth()) + 1);
    rest_[l].clear();
    meet(receiver, candidates, rest_[l]);
    if (tree_.leaf(receiver)) return;
    meet_all_below(2 * receiver + 1, rest_[l], level + 1);
    meet_all_below(2 * receiver + 2, rest_[l], level + 1);
  }

 private:
  const ClusterTree& tree_;
  const Oracle& oracle_;
  Links& links_;
  std::vector<int> stack_;
  std::vector<std::vector<int>> rest_;  ///< per level
};

}  // namespace

bool Oracle::holds(const Eigen::Array4f& receiver, const Eigen::Array4f& emitter) const {
  const float x = receiver[0] - emitter[0], y = receiver[1] - emitter[1],
              z = receiver[2] - emitter[2];
  const float s = std::sqrt(x * x + y * y + z * z + smooth * smooth);
  const float rho = receiver[3] + emitter[3];
  if (rho > opening * s) return false;
  if (rho * (3.0F + decay * s) <= 3.0F * opening * s) return true;
  // e^q >= 1 + q + q²/2 + q³/6, without a call.
  const float q = least_decay * s / 6.0F;
  const float relaxed = 1.0F + q * (1.0F + q * (0.5F + q / 6.0F));
  return rho * (3.0F + decay * s) <= 3.0F * opening * s * relaxed;
}

Links link(const ClusterTree& tree, const Oracle& oracle) {
  Links links;
  links.of_cluster.resize(tree.clusters());
  links.of_leaf.resize(tree.clusters() - tree.first_leaf());
  const int level = std::min(pair_task_level, tree.depth());
  const std::size_t tasks = std::size_t{1} << level, above = tasks - 1;

  // The clusters above the tasks, in their order; then each task with all below it.
  Linker top(tree, oracle, links);
  std::vector<std::vector<int>> candidates(2 * tasks - 1);
  candidates[0] = {0};
  for (std::size_t k = 0; k < above; ++k) {
    std::vector<int> rest;
    top.meet(k, candidates[k], rest);
    candidates[2 * k + 1] = candidates[2 * k + 2] = std::move(rest);
  }
  std::vector<Linker> part(tasks, Linker(tree, oracle, links));
  for_rows(static_cast<int>(tasks), [&](int task) {
    const auto t = static_cast<std::size_t>(task);
    part[t].meet_all_below(above + t, candidates[above + t], level);
  });

  std::vector<std::size_t> emitter_base(tasks + 1, top.emitter.size()), near_base(tasks + 1, 0);
  for (std::size_t t = 0; t < tasks; ++t) {
    emitter_base[t + 1] = emitter_base[t] + part[t].emitter.size();
    near_base[t + 1] = near_base[t] + part[t].near.size();
  }
  links.emitter.resize(emitter_base[tasks]);
  links.near.resize(near_base[tasks]);
  std::copy(top.emitter.begin(), top.emitter.end(), links.emitter.begin());
  for_rows(static_cast<int>(tasks), [&](int task) {
    const auto t = static_cast<std::size_t>(task);
    std::copy(part[t].emitter.begin(), part[t].emitter.end(),
              links.emitter.begin() + static_cast<std::ptrdiff_t>(emitter_base[t]));
    std::copy(part[t].near.begin(), part[t].near.end(),
              links.near.begin() + static_cast<std::ptrdiff_t>(near_base[t]));
    for (int l = level; l <= tree.depth(); ++l) {
      const std::size_t width = std::size_t{1} << (l - level);
      const std::size_t first = (std::size_t{1} << l) - 1 + t * width;
      for (std::size_t k = first; k < first + width; ++k) {
        links.of_cluster[k].first += static_cast<int>(emitter_base[t]);
        if (l == tree.depth()) {
          links.of_leaf[k - tree.first_leaf()].first += static_cast<int>(near_base[t]);
        }
      }
    }
  });
  return links;
}

}  // namespace kappamu::forward::dipole
