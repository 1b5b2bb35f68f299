#include "forward/embedded/equations/node_space.h"

#include <algorithm>

#include "core/error.h"
#include "core/parallel.h"

namespace kappamu::forward::embedded {

namespace {

/// A lattice point, in units of the deepest level.
using Point = std::array<std::uint64_t, 3>;

std::uint64_t key_of(const Point& p) {
  return p[0] | (p[1] << 21U) | (p[2] << 42U);
}

/// Lattice points in order of appearance; open addressing.
class PointTable {
 public:
  explicit PointTable(std::size_t expected) {
    std::size_t size = 64;
    while (size < 2 * expected) size *= 2;
    slot_.assign(size, {empty, 0});
  }
  int find(std::uint64_t key) const {
    const auto& found = slot_[place(key)];
    return found.first == key ? found.second : -1;
  }
  int insert(std::uint64_t key) {
    auto& found = slot_[place(key)];
    if (found.first == key) return found.second;
    found = {key, count_++};
    if (2 * static_cast<std::size_t>(count_) > slot_.size()) grow();
    return count_ - 1;
  }
  int size() const { return count_; }

 private:
  static constexpr std::uint64_t empty = ~std::uint64_t{0};
  std::size_t place(std::uint64_t key) const {
    std::uint64_t hash = key * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 29U;
    std::size_t at = hash & (slot_.size() - 1);
    while (slot_[at].first != key && slot_[at].first != empty) at = (at + 1) & (slot_.size() - 1);
    return at;
  }
  void grow() {
    std::vector<std::pair<std::uint64_t, int>> old(2 * slot_.size(), {empty, 0});
    old.swap(slot_);
    for (const auto& entry : old) {
      if (entry.first != empty) slot_[place(entry.first)] = entry;
    }
  }
  std::vector<std::pair<std::uint64_t, int>> slot_;
  int count_ = 0;
};

bool siblings(const Cube& one, const Cube& other) {
  bool same = one.level == other.level;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    same = same && one.at[axis] / 2 == other.at[axis] / 2;
  }
  return same;
}

}  // namespace

NodeSpace::NodeSpace(const std::vector<Cube>& cubes) : corner_(cubes.size()) {
  const auto point = [](const Cube& cube, int x, int y, int z) {
    // Halves of the cube's edge, so that (1, 1, 1) is its centre.
    const auto half = static_cast<unsigned>(deepest_level - cube.level);
    return Point{(2ULL * cube.at[0] + static_cast<unsigned>(x)) << half,
                 (2ULL * cube.at[1] + static_cast<unsigned>(y)) << half,
                 (2ULL * cube.at[2] + static_cast<unsigned>(z)) << half};
  };
  const auto corner_point = [&](const Cube& cube, int i) {
    return point(cube, 2 * (i & 1), (i & 2), 2 * (i >> 2 & 1));
  };
  // 1. Every corner is a node. Siblings follow each other and share theirs.
  PointTable table(cubes.size() + cubes.size() / 2);
  int finest = 0;
  std::array<int, 27> shared{};  // of the parent's lattice of corners, edges' middles, ...
  for (std::size_t k = 0; k < cubes.size(); ++k) {
    const Cube& cube = cubes[k];
    finest = std::max(finest, cube.level);
    if (k == 0 || !siblings(cube, cubes[k - 1])) shared.fill(-1);
    for (unsigned i = 0; i < 8; ++i) {
      const unsigned x = (cube.at[0] & 1U) + (i & 1U), y = (cube.at[1] & 1U) + (i >> 1U & 1U),
                     z = (cube.at[2] & 1U) + (i >> 2U);
      int& node = shared[x + 3 * y + 9 * z];
      if (node < 0) node = table.insert(key_of(corner_point(cube, static_cast<int>(i))));
      corner_[k][i] = node;
    }
  }
  // 2. Nodes in the middle of an edge or face hang.
  struct Middle {
    std::size_t cube;
    int node, place;  ///< in the cube's lattice of halves
  };
  constexpr std::size_t chunk = 4096;
  std::vector<std::vector<Middle>> middles(pieces(cubes.size(), chunk));
  for_pieces(cubes.size(), chunk, [&](std::size_t part, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (cubes[k].level == finest) continue;
      for (int place = 0; place < 27; ++place) {
        const int x = place % 3, y = place / 3 % 3, z = place / 9;
        const int halves = (x & 1) + (y & 1) + (z & 1);
        if (halves != 1 && halves != 2) continue;
        const int node = table.find(key_of(point(cubes[k], x, y, z)));
        if (node >= 0) middles[part].push_back({k, node, place});
      }
    }
  });
  std::vector<int> hanging(static_cast<std::size_t>(table.size()), 0);  // ~place in masters_
  for (const auto& part : middles) {
    for (const auto& [k, node, place] : part) {
      if (hanging[static_cast<std::size_t>(node)] != 0) continue;
      hanging[static_cast<std::size_t>(node)] = ~static_cast<int>(masters_.size());
      const std::array<int, 3> at{place % 3, place / 3 % 3, place / 9};
      masters_.push_back(std::count(at.begin(), at.end(), 1) == 1 ? 2 : 4);
      for (int i = 0; i < 8; ++i) {
        bool on = true;
        for (int axis = 0; axis < 3; ++axis) {
          const int a = at[static_cast<std::size_t>(axis)];
          on = on && (a == 1 || a == 2 * (i >> axis & 1));
        }
        if (on) masters_.push_back(corner_[k][static_cast<std::size_t>(i)]);
      }
    }
  }
  // 3. The others are the unknowns.
  std::vector<int> unknown(hanging.size());
  for (std::size_t node = 0; node < hanging.size(); ++node) {
    unknown[node] = hanging[node] != 0 ? hanging[node] : static_cast<int>(unknowns_++);
  }
  for (auto& corners : corner_) {
    for (int& code : corners) code = unknown[static_cast<std::size_t>(code)];
  }
  for (std::size_t begin = 0; begin < masters_.size();) {
    const auto count = static_cast<std::size_t>(masters_[begin]);
    for (std::size_t m = 1; m <= count; ++m) {
      masters_[begin + m] = unknown[static_cast<std::size_t>(masters_[begin + m])];
      check(masters_[begin + m] >= 0,
            "the octree is not balanced: a hanging node hangs on another");
    }
    begin += count + 1;
  }
}

}  // namespace kappamu::forward::embedded
