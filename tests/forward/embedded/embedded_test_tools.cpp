#include "embedded_test_tools.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

namespace kappamu::forward::embedded {

TriangleMesh icosphere(double radius, int splits, const Eigen::Vector3d& centre) {
  const double g = std::numbers::phi;
  TriangleMesh mesh;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      mesh.vertices.insert(mesh.vertices.end(), {{0.0, a, b}, {a, b, 0.0}, {b, 0.0, a}});
    }
  }
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      for (int k = 0; k < 12; ++k) {
        const auto& p = mesh.vertices[static_cast<std::size_t>(i)];
        const auto& q = mesh.vertices[static_cast<std::size_t>(j)];
        const auto& r = mesh.vertices[static_cast<std::size_t>(k)];
        const bool edges = (p - q).norm() < 2.1 && (q - r).norm() < 2.1 && (r - p).norm() < 2.1;
        if (i < j && i < k && j != k && edges && (q - p).cross(r - p).dot(p) > 0.0) {
          mesh.triangles.push_back({i, j, k});
        }
      }
    }
  }
  for (auto& vertex : mesh.vertices) vertex.normalize();
  for (int split = 0; split < splits; ++split) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [place, made] = middles.try_emplace(std::minmax(a, b),
                                                     static_cast<int>(mesh.vertices.size()));
      if (made) {
        mesh.vertices.push_back((mesh.vertices[static_cast<std::size_t>(a)] +
                                 mesh.vertices[static_cast<std::size_t>(b)])
                                    .normalized());
      }
      return place->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = finer;
  }
  const double scale =
      radius * std::cbrt(4.0 / 3.0 * std::numbers::pi / enclosed_volume(mesh));
  for (auto& vertex : mesh.vertices) vertex = centre + scale * vertex;
  return mesh;
}

TriangleMesh box(const Eigen::Vector3d& size, int cells) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> numbers;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [place, made] = numbers.try_emplace(at, static_cast<int>(mesh.vertices.size()));
    if (made) {
      mesh.vertices.push_back(size.cwiseProduct(Eigen::Vector3d(at[0], at[1], at[2])) / cells);
    }
    return place->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      for (int u = 0; u < cells; ++u) {
        for (int v = 0; v < cells; ++v) {
          const auto corner = [&](int du, int dv) {
            std::array<int, 3> at{};
            at[axis] = upper ? cells : 0;
            at[(axis + 1) % 3] = u + du;
            at[(axis + 2) % 3] = v + dv;
            return vertex(at);
          };
          const int a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
          if (upper) {
            mesh.triangles.insert(mesh.triangles.end(), {{a, b, c}, {a, c, d}});
          } else {
            mesh.triangles.insert(mesh.triangles.end(), {{a, c, b}, {a, d, c}});
          }
        }
      }
    }
  }
  return mesh;
}

TriangleMesh transformed(TriangleMesh mesh, const Eigen::Affine3d& by) {
  for (auto& vertex : mesh.vertices) vertex = by * vertex;
  return mesh;
}

TriangleMesh joined(TriangleMesh one, const TriangleMesh& other, bool inside_out) {
  const int before = static_cast<int>(one.vertices.size());
  one.vertices.insert(one.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (auto [a, b, c] : other.triangles) {
    if (inside_out) std::swap(b, c);
    one.triangles.push_back({a + before, b + before, c + before});
  }
  return one;
}

namespace {

class BoxTree : public RayCaster {
 public:
  explicit BoxTree(const TriangleMesh& mesh) : mesh_(mesh), order_(mesh.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    build(0, order_.size());
  }
  std::optional<RayHit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  double nearest, double farthest) const override {
    std::optional<RayHit> best;
    visit(0, origin, direction, nearest, farthest, best);
    return best;
  }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::size_t begin = 0, end = 0;
    int right = -1;  ///< the left child follows the node; −1: a leaf
  };
  const Eigen::Vector3d& vertex(int triangle, std::size_t k) const {
    return mesh_.vertices[static_cast<std::size_t>(
        mesh_.triangles[static_cast<std::size_t>(triangle)][k])];
  }
  int build(std::size_t begin, std::size_t end) {
    const auto here = nodes_.size();
    nodes_.push_back({{}, begin, end, -1});
    Eigen::AlignedBox3d box;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t k = 0; k < 3; ++k) box.extend(vertex(order_[i], k));
    }
    nodes_[here].box = box;
    if (end - begin > 4) {
      int axis = 0;
      box.sizes().maxCoeff(&axis);
      const std::size_t middle = (begin + end) / 2;
      std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                       order_.begin() + static_cast<std::ptrdiff_t>(middle),
                       order_.begin() + static_cast<std::ptrdiff_t>(end), [&](int a, int b) {
                         return vertex(a, 0)[axis] + vertex(a, 1)[axis] + vertex(a, 2)[axis] <
                                vertex(b, 0)[axis] + vertex(b, 1)[axis] + vertex(b, 2)[axis];
                       });
      build(begin, middle);
      nodes_[here].right = build(middle, end);
    }
    return static_cast<int>(here);
  }
  void visit(int index, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
             double nearest, double& farthest, std::optional<RayHit>& best) const {
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    double from = nearest, to = farthest;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (node.box.min()[axis] - origin[axis]) / direction[axis];
      const double b = (node.box.max()[axis] - origin[axis]) / direction[axis];
      from = std::max(from, std::min(a, b) - 1e-12);
      to = std::min(to, std::max(a, b) + 1e-12);
    }
    if (!(from <= to)) return;
    if (node.right >= 0) {
      visit(index + 1, origin, direction, nearest, farthest, best);
      visit(node.right, origin, direction, nearest, farthest, best);
      return;
    }
    for (std::size_t i = node.begin; i < node.end; ++i) {
      const Eigen::Vector3d& p = vertex(order_[i], 0);
      const Eigen::Vector3d e1 = vertex(order_[i], 1) - p, e2 = vertex(order_[i], 2) - p;
      const Eigen::Vector3d across = direction.cross(e2);
      const double determinant = e1.dot(across);
      if (determinant == 0.0) continue;
      const Eigen::Vector3d s = origin - p;
      const double u = s.dot(across) / determinant;
      const double v = direction.dot(s.cross(e1)) / determinant;
      const double t = e2.dot(s.cross(e1)) / determinant;
      if (u < 0.0 || v < 0.0 || u + v > 1.0 || t <= nearest || t >= farthest) continue;
      farthest = t;
      best = RayHit{t, order_[i], u, v};
    }
  }

  const TriangleMesh& mesh_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace

std::unique_ptr<RayCaster> make_caster(const TriangleMesh& mesh) {
  return std::make_unique<BoxTree>(mesh);
}

}  // namespace kappamu::forward::embedded
