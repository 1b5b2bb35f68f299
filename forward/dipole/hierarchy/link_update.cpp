// Links kept from shape to shape ([M] 5.5).
#include <algorithm>
#include <bit>
#include <cmath>

#include "core/parallel.h"
#include "forward/dipole/hierarchy/links.h"

namespace kappamu::forward::dipole {

namespace {

constexpr std::size_t clusters_per_piece = 2048;

/// Two links that one link could replace; of a leaf's near pairs, one.
struct Promotion {
  int receiver, emitter;
  std::size_t first, second;
};

/// A link that does not hold, and how large its clusters are against their distance.
struct Failure {
  float severity;
  int receiver;
  std::size_t link;
};

struct Found {
  std::vector<Failure> failures;
  std::vector<Promotion> promotions, from_near;
};

struct Pair {
  int receiver, emitter;
};

/// Emitters of a list stand in the order of their triangles.
std::pair<std::size_t, int> place_in(const ClusterTree& tree, int cluster) {
  const auto number = static_cast<std::size_t>(cluster) + 1;
  const int level = static_cast<int>(std::bit_width(number)) - 1;
  return {number << (tree.depth() - level), level};
}

class LinkUpdate {
 public:
  LinkUpdate(Links& links, const ClusterTree& tree, const Oracle& wide, const Oracle& narrow)
      : links_(links), tree_(tree), wide_(wide), narrow_(narrow) {}

  LinkChanges run(std::size_t most) {
    Found found = find();
    LinkChanges changes{found.failures.size()};
    if (static_cast<double>(changes.failing) >
            all_anew * static_cast<double>(links_.emitter.size()) &&
        most >= changes.failing) {
      changes.demoted = changes.failing;
      changes.too_many = true;
      return changes;
    }
    if (most < changes.failing) {
      std::nth_element(
          found.failures.begin(), found.failures.begin() + static_cast<std::ptrdiff_t>(most),
          found.failures.end(), [](const Failure& a, const Failure& b) {
            return a.severity != b.severity ? a.severity > b.severity : a.link < b.link;
          });
      found.failures.resize(most);
    }
    gone_.assign(links_.emitter.size(), 0);
    near_gone_.assign(links_.near.size(), 0);
    changes.demoted = found.failures.size();
    for (const Failure& failure : found.failures) {
      gone_[failure.link] = 1;
      demote(failure.receiver, links_.emitter[failure.link]);
    }
    promote(found, most - changes.demoted, changes);
    if (changes.demoted + changes.promoted > 0) rebuild();
    return changes;
  }

 private:
  const Eigen::Array4f& at(int cluster) const {
    return tree_.cluster()[static_cast<std::size_t>(cluster)];
  }
  bool holds(const Oracle& oracle, int receiver, int emitter) const {
    return oracle.holds(tree_, static_cast<std::size_t>(receiver),
                        static_cast<std::size_t>(emitter));
  }

  std::pair<std::size_t, int> place(int cluster) const { return place_in(tree_, cluster); }

  Found find() const {
    std::vector<Found> pieces_found(pieces(tree_.clusters(), clusters_per_piece));
    for_pieces(tree_.clusters(), clusters_per_piece,
               [&](std::size_t piece, std::size_t begin, std::size_t end) {
                 for (std::size_t k = begin; k < end; ++k) look_at(k, pieces_found[piece]);
               });
    Found found;
    for (const Found& piece : pieces_found) {
      const auto append = [](auto& to, const auto& from) {
        to.insert(to.end(), from.begin(), from.end());
      };
      append(found.failures, piece.failures);
      append(found.promotions, piece.promotions);
      append(found.from_near, piece.from_near);
    }
    return found;
  }

  void look_at(std::size_t k, Found& found) const {
    const int receiver = static_cast<int>(k);
    const auto first = static_cast<std::size_t>(links_.of_cluster[k].first);
    const std::size_t last = first + static_cast<std::size_t>(links_.of_cluster[k].count);
    for (std::size_t i = first; i < last; ++i) {
      const int emitter = links_.emitter[i];
      if (!holds(wide_, receiver, emitter)) {
        const float apart = (at(receiver) - at(emitter)).head<3>().matrix().norm();
        found.failures.push_back(
            {(at(receiver)[3] + at(emitter)[3]) / (apart + wide_.smooth), receiver, i});
      }
      const bool siblings =
          i + 1 < last && emitter % 2 == 1 && links_.emitter[i + 1] == emitter + 1;
      if (siblings && holds(narrow_, receiver, (emitter - 1) / 2)) {
        found.promotions.push_back({receiver, (emitter - 1) / 2, i, i + 1});
      }
    }
    if (!tree_.leaf(k)) return look_at_children(k, found);
    const LinkRange near = links_.of_leaf[k - tree_.first_leaf()];
    for (int i = near.first; i < near.first + near.count; ++i) {
      const int emitter =
          links_.near[static_cast<std::size_t>(i)] + static_cast<int>(tree_.first_leaf());
      if (holds(narrow_, receiver, emitter)) {
        found.from_near.push_back({receiver, emitter, static_cast<std::size_t>(i), 0});
      }
    }
  }

  /// Emitters that both children of k have.
  void look_at_children(std::size_t k, Found& found) const {
    const LinkRange &one = links_.of_cluster[2 * k + 1], &other = links_.of_cluster[2 * k + 2];
    int i = one.first, j = other.first;
    while (i < one.first + one.count && j < other.first + other.count) {
      const int e = links_.emitter[static_cast<std::size_t>(i)];
      const int f = links_.emitter[static_cast<std::size_t>(j)];
      if (e == f) {
        if (holds(narrow_, static_cast<int>(k), e)) {
          found.promotions.push_back(
              {static_cast<int>(k), e, static_cast<std::size_t>(i), static_cast<std::size_t>(j)});
        }
        ++i, ++j;
      } else if (place(e) < place(f)) {
        ++i;
      } else {
        ++j;
      }
    }
  }

  void demote(int receiver, int emitter) {
    switch (narrow_.meet(tree_, static_cast<std::size_t>(receiver),
                         static_cast<std::size_t>(emitter))) {
      case Oracle::Meeting::linked:
        added_.push_back({receiver, emitter});
        break;
      case Oracle::Meeting::emitter_opens:
        demote(receiver, 2 * emitter + 1);
        demote(receiver, 2 * emitter + 2);
        break;
      case Oracle::Meeting::receiver_opens:
        if (tree_.leaf(static_cast<std::size_t>(receiver))) {
          near_added_.push_back({receiver, emitter});
        } else {
          demote(2 * receiver + 1, emitter);
          demote(2 * receiver + 2, emitter);
        }
    }
  }

  void promote(const Found& found, std::size_t most, LinkChanges& changes) {
    for (const Promotion& one : found.promotions) {
      if (changes.promoted == most) return;
      if (gone_[one.first] != 0 || gone_[one.second] != 0) continue;
      gone_[one.first] = gone_[one.second] = 1;
      added_.push_back({one.receiver, one.emitter});
      ++changes.promoted;
    }
    for (const Promotion& one : found.from_near) {
      if (changes.promoted == most) return;
      near_gone_[one.first] = 1;
      added_.push_back({one.receiver, one.emitter});
      ++changes.promoted;
    }
  }

  /// A list of ranges without what is gone and with what was added, `first_owner` being the number
  /// of the cluster that the first range is of, `base` that of the first emitter.
  void rebuild_list(std::vector<LinkRange>& ranges, std::vector<int>& emitters,
                    const std::vector<char>& gone, std::vector<Pair>& added, int first_owner,
                    int base) const {
    std::sort(added.begin(), added.end(), [&](const Pair& a, const Pair& b) {
      return a.receiver != b.receiver ? a.receiver < b.receiver
                                      : place(a.emitter) < place(b.emitter);
    });
    std::vector<int> list;
    list.reserve(emitters.size() + added.size());
    auto next = added.begin();
    for (std::size_t k = 0; k < ranges.size(); ++k) {
      const LinkRange was = ranges[k];
      const auto first = static_cast<std::ptrdiff_t>(list.size());
      for (int i = was.first; i < was.first + was.count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (gone[at] == 0) list.push_back(emitters[at]);
      }
      const auto middle = static_cast<std::ptrdiff_t>(list.size());
      for (; next != added.end() && next->receiver == first_owner + static_cast<int>(k); ++next) {
        list.push_back(next->emitter - base);
      }
      std::inplace_merge(list.begin() + first, list.begin() + middle, list.end(),
                         [&](int a, int b) { return place(a + base) < place(b + base); });
      ranges[k] = {static_cast<int>(first),
                   static_cast<int>(list.size()) - static_cast<int>(first)};
    }
    emitters = std::move(list);
  }

  void rebuild() {
    const int leaves = static_cast<int>(tree_.first_leaf());
    rebuild_list(links_.of_cluster, links_.emitter, gone_, added_, 0, 0);
    rebuild_list(links_.of_leaf, links_.near, near_gone_, near_added_, leaves, leaves);
  }

  Links& links_;
  const ClusterTree& tree_;
  const Oracle &wide_, &narrow_;
  std::vector<char> gone_, near_gone_;
  std::vector<Pair> added_, near_added_;
};

}  // namespace

void put_in_order(Links& links, const ClusterTree& tree) {
  const auto sort = [&](const LinkRange& range, std::vector<int>& emitters, int base) {
    const auto first = emitters.begin() + range.first;
    std::sort(first, first + range.count,
              [&](int a, int b) { return place_in(tree, a + base) < place_in(tree, b + base); });
  };
  for (const LinkRange& range : links.of_cluster) sort(range, links.emitter, 0);
  for (const LinkRange& range : links.of_leaf) {
    sort(range, links.near, static_cast<int>(tree.first_leaf()));
  }
}

LinkChanges update(Links& links, const ClusterTree& tree, const Oracle& wide, const Oracle& narrow,
                   std::size_t most) {
  return LinkUpdate(links, tree, wide, narrow).run(most);
}

}  // namespace kappamu::forward::dipole
