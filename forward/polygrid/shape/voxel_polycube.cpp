#include "forward/polygrid/shape/voxel_polycube.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "core/mesh/lattice_box.h"

namespace kappamu::forward {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

constexpr int samples = 4;  ///< along a cell's edge

/// How much of each lattice cell lies in the mesh, from 0 to 1, by samples on lines along x.
LatticeBox<float> share_inside(const TriangleMesh& mesh, const Vector3d& origin, double spacing) {
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const auto place = [&](const Vector3d& p) {
    return Vector3i(((p - origin) / spacing).array().floor().cast<int>());
  };
  LatticeBox<float> share(place(box.min()) - Vector3i::Ones(), place(box.max()) + Vector3i::Ones(),
                          0.0F);
  const double step = spacing / samples;
  const Vector3d first = origin + spacing * share.low().cast<double>();
  const int ny = samples * share.size().y(), nz = samples * share.size().z();
  // A line lies off the middle of its square, so that it seldom meets vertices of regular meshes.
  const Eigen::Vector2d off(0.5 + 0.0137, 0.5 - 0.0219);
  std::vector<std::vector<std::pair<double, int>>> crossings(static_cast<std::size_t>(ny) *
                                                             static_cast<std::size_t>(nz));
  for (const auto& t : mesh.triangles) {
    std::array<Vector3d, 3> v;
    for (std::size_t k = 0; k < 3; ++k) {
      v[k] = (mesh.vertices[static_cast<std::size_t>(t[k])] - first) / step;
      v[k].tail<2>() -= off;
    }
    const auto cross = [](const Vector3d& a, const Vector3d& b, double y, double z) {
      return (b.y() - a.y()) * (z - a.z()) - (b.z() - a.z()) * (y - a.y());
    };
    const double area = cross(v[0], v[1], v[2].y(), v[2].z());
    if (area == 0.0) continue;
    const auto [y0, y1] = std::minmax({v[0].y(), v[1].y(), v[2].y()});
    const auto [z0, z1] = std::minmax({v[0].z(), v[1].z(), v[2].z()});
    for (int z = std::max(0, static_cast<int>(std::ceil(z0)));
         z <= std::min(nz - 1, static_cast<int>(z1)); ++z) {
      for (int y = std::max(0, static_cast<int>(std::ceil(y0)));
           y <= std::min(ny - 1, static_cast<int>(y1)); ++y) {
        const double a = cross(v[1], v[2], y, z) / area, b = cross(v[2], v[0], y, z) / area,
                     c = cross(v[0], v[1], y, z) / area;
        if (a < 0.0 || b < 0.0 || c < 0.0) continue;
        const std::size_t line = static_cast<std::size_t>(y) +
                                 static_cast<std::size_t>(ny) * static_cast<std::size_t>(z);
        crossings[line].emplace_back(a * v[0].x() + b * v[1].x() + c * v[2].x(),
                                     area > 0.0 ? -1 : 1);
      }
    }
  }
  for (int z = 0; z < nz; ++z) {
    for (int y = 0; y < ny; ++y) {
      auto& line = crossings[static_cast<std::size_t>(y) +
                             static_cast<std::size_t>(ny) * static_cast<std::size_t>(z)];
      std::sort(line.begin(), line.end());
      int winding = 0;
      for (std::size_t k = 0; k + 1 < line.size(); ++k) {
        winding += line[k].second;
        if (winding <= 0) continue;
        const int begin = static_cast<int>(std::ceil(line[k].first - 0.5));
        const int end = static_cast<int>(std::ceil(line[k + 1].first - 0.5));
        for (int x = begin; x < end; ++x) {
          const Vector3i at = share.low() + Vector3i(x / samples, y / samples, z / samples);
          if (share.holds(at)) share[at] += 1.0F / (samples * samples * samples);
        }
      }
    }
  }
  return share;
}

class Mending {
 public:
  explicit Mending(LatticeBox<float> share)
      : share_(std::move(share)),
        filled_(share_.low(), share_.low() + share_.size() - Vector3i::Ones(), 0) {
    share_.for_each([&](const Vector3i& place, float inside) {
      if (inside >= 0.5F) filled_[place] = 1;
    });
    keep_largest(1);
    reach_thin_parts();
    make_manifold();
    keep_largest(1);
    keep_largest(0);  // fills what is closed off
    make_manifold();
  }

  std::vector<Vector3i> cells() const {
    std::vector<Vector3i> cells;
    filled_.for_each([&](const Vector3i& place, int value) {
      if (value != 0) cells.push_back(place);
    });
    return cells;
  }
  /// Volume of where cells and object differ, in cells.
  double difference() const {
    double sum = 0.0;
    share_.for_each([&](const Vector3i& place, float inside) {
      sum += std::abs(static_cast<double>(inside) - filled_.at(place));
    });
    return sum;
  }

 private:
  /// Of the pieces of cells of this value all but the largest take the other.
  void keep_largest(int value) {
    LatticeBox<int> piece(filled_.low(), filled_.low() + filled_.size() - Vector3i::Ones(), 0);
    std::vector<std::size_t> size{0};
    std::vector<Vector3i> open;
    filled_.for_each([&](const Vector3i& start, int there) {
      if (there != value || piece[start] != 0) return;
      const int number = static_cast<int>(size.size());
      size.push_back(1);
      piece[start] = number;
      open.push_back(start);
      while (!open.empty()) {
        const Vector3i cell = open.back();
        open.pop_back();
        for (int side = 0; side < 6; ++side) {
          const Vector3i next = cell + lattice_side(side);
          if (!filled_.holds(next) || filled_.at(next) != value || piece[next] != 0) continue;
          piece[next] = number;
          ++size.back();
          open.push_back(next);
        }
      }
    });
    const auto largest = std::max_element(size.begin(), size.end()) - size.begin();
    piece.for_each([&](const Vector3i& place, int number) {
      if (number != 0 && number != largest) filled_[place] = 1 - value;
    });
  }

  bool near_filled(const Vector3i& place) const {
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          if (filled_.at(place + Vector3i(x, y, z)) != 0) return true;
        }
      }
    }
    return false;
  }

  /// Cells of parts thinner than half a cell, with none filled around them, join by the way on
  /// which cells lie in the object most (Dijkstra, from the filled cells).
  void reach_thin_parts() {
    const Vector3i high = share_.low() + share_.size() - Vector3i::Ones();
    constexpr float far = 1e9F;
    LatticeBox<float> cost(share_.low(), high, far);
    LatticeBox<int> from(share_.low(), high, -1);
    using Step = std::pair<float, std::array<int, 3>>;
    std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
    const auto reach = [&](const Vector3i& place, float value) {
      cost[place] = value;
      open.emplace(value, std::array<int, 3>{place.x(), place.y(), place.z()});
    };
    std::vector<Vector3i> thin;
    share_.for_each([&](const Vector3i& place, float inside) {
      if (filled_.at(place) != 0) reach(place, 0.0F);
      if (inside > 0.0F && !near_filled(place)) thin.push_back(place);
    });
    if (thin.empty()) return;
    while (!open.empty()) {
      const auto [value, at] = open.top();
      open.pop();
      const Vector3i place(at[0], at[1], at[2]);
      if (value > cost.at(place)) continue;
      for (int side = 0; side < 6; ++side) {
        const Vector3i next = place + lattice_side(side);
        const float inside = share_.at(next);
        if (!share_.holds(next) || inside <= 0.0F) continue;
        const float there = value + 1.02F - inside;
        if (there >= cost.at(next)) continue;
        from[next] = side ^ 1;
        reach(next, there);
      }
    }
    for (Vector3i place : thin) {
      if (cost.at(place) >= far || near_filled(place)) continue;
      for (; filled_.at(place) == 0; place += lattice_side(from.at(place))) filled_[place] = 1;
    }
  }

  unsigned around(const Vector3i& corner) const {
    unsigned cells = 0;
    for (int b = 0; b < 8; ++b) {
      if (filled_.at(corner - Vector3i::Ones() + lattice_corner(b)) != 0) cells |= 1U << b;
    }
    return cells;
  }

  /// Turns single cells, each at most once, until every corner is a manifold's: of those that mend
  /// the corner, the one that agrees best with the object.
  void make_manifold() {
    LatticeBox<int> turned(filled_.low(), filled_.low() + filled_.size() - Vector3i::Ones(), 0);
    for (bool changed = true; changed;) {
      changed = false;
      filled_.for_each([&](const Vector3i& corner, int) {
        const unsigned cells = around(corner);
        if (manifold_corner(cells)) return;
        int best = 8;
        double best_cost = 1e9;
        for (int b = 0; b < 8; ++b) {
          const Vector3i place = corner - Vector3i::Ones() + lattice_corner(b);
          if (!filled_.holds(place) || turned[place] != 0) continue;
          const double inside = share_.at(place);
          const double cost = ((cells >> b & 1U) != 0 ? inside : 1.0 - inside) +
                              (manifold_corner(cells ^ 1U << b) ? 0.0 : 10.0);
          if (cost < best_cost) {
            best_cost = cost;
            best = b;
          }
        }
        if (best == 8) return;
        const Vector3i place = corner - Vector3i::Ones() + lattice_corner(best);
        filled_[place] = 1 - filled_.at(place);
        turned[place] = 1;
        changed = true;
      });
    }
  }

  LatticeBox<float> share_;
  LatticeBox<int> filled_;
};

}  // namespace

std::optional<Polycube> voxel_polycube(const TriangleMesh& mesh, double spacing, int wanted,
                                       const std::function<void()>& report) {
  const Vector3d centre = bounding_box(mesh).center();
  std::optional<Polycube> best;
  double best_difference = 0.0;
  for (int shift = 0; shift < 8; ++shift) {
    const Vector3d origin = centre + 0.5 * spacing * lattice_corner(shift).cast<double>();
    report();
    LatticeBox<float> share = share_inside(mesh, origin, spacing);
    report();
    const Mending mended(std::move(share));
    report();
    std::vector<Vector3i> cells = mended.cells();
    if (best && mended.difference() >= best_difference) continue;
    if (cells.empty() || polycube_problem(cells) || genus(cells) != wanted) continue;
    best_difference = mended.difference();
    best = lattice_polycube(std::move(cells), origin, spacing);
  }
  return best;
}

}  // namespace kappamu::forward
