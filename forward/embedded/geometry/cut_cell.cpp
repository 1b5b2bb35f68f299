#include "forward/embedded/geometry/cut_cell.h"

#include <Eigen/Geometry>
#include <cmath>

namespace kappamu::forward::embedded {

namespace {

// Gauss-Legendre rule on [0, 1], exact to degree 5.
constexpr std::array<double, 3> node3{0.1127016653792583, 0.5, 0.8872983346207417};
constexpr std::array<double, 3> weight3{0.2777777777777778, 0.4444444444444444, 0.2777777777777778};

/// Rule on a triangle of area ½, exact to degree 7 (Gatermann 1988): each entry stands for three
/// points, its first two barycentric weights turned round.
struct TriangleNode {
  double a, b, weight;
};
constexpr std::array<TriangleNode, 4> triangle_nodes{
    {{0.06238226509439084, 0.06751786707392436, 0.02651702815743450},
     {0.05522545665692000, 0.32150249385198182, 0.04388140871444811},
     {0.03432430294509488, 0.66094919618673565, 0.02877504278497528},
     {0.51584233435359177, 0.27771616697639178, 0.06749318700980879}}};

/// x^a y^b for a, b ≤ 2, a fastest.
std::array<double, 9> plane_powers(double x, double y) {
  return {1.0, x, x * x, y, x * y, x * x * y, y * y, x * y * y, x * x * y * y};
}

/// Below this, of a cube's volume, rounding decides on which side a piece lies.
constexpr double lost_to_rounding = 1e-9;

}  // namespace

void CutCell::add(int triangle, const Triangle& corners) {
  const Polygon polygon = clipped_to_unit_cube(corners);
  if (polygon.size == 0) return;
  const Eigen::Vector3d normal =
      (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  // ∫ x^a y^b z^c dA over the piece, c ≤ 3.
  std::array<std::array<double, 9>, 4> moment{};
  for (std::size_t i = 1; i + 1 < static_cast<std::size_t>(polygon.size); ++i) {
    const Eigen::Vector3d& p = polygon.vertex[0];
    const Eigen::Vector3d& q = polygon.vertex[i];
    const Eigen::Vector3d& r = polygon.vertex[i + 1];
    const double doubled = (q - p).cross(r - p).norm();
    if (!(doubled > 0.0)) continue;
    for (const TriangleNode& node : triangle_nodes) {
      const double c = 1.0 - node.a - node.b;
      for (const Eigen::Vector3d& x : {Eigen::Vector3d(node.a * p + node.b * q + c * r),
                                       Eigen::Vector3d(node.b * p + c * q + node.a * r),
                                       Eigen::Vector3d(c * p + node.a * q + node.b * r)}) {
        const std::array<double, 9> term = plane_powers(x.x(), x.y());
        double power = node.weight * doubled;
        for (auto& of_power : moment) {
          for (std::size_t ab = 0; ab < 9; ++ab) of_power[ab] += power * term[ab];
          power *= x.z();
        }
      }
    }
  }
  if (!(moment[0][0] > 0.0)) return;
  for (std::size_t c = 0; c < 3; ++c) {
    const double in_volume = normal.z() / (static_cast<double>(c) + 1.0);
    for (std::size_t ab = 0; ab < 9; ++ab) {
      surface_[9 * c + ab] += moment[c][ab];
      volume_[9 * c + ab] += in_volume * moment[c + 1][ab];
    }
  }
  SurfacePiece piece{triangle, {}};
  for (std::size_t k = 0; k < 8; ++k) piece.weight[k] = moment[k >> 2][(k & 1) + 3 * (k >> 1 & 1)];
  for (std::size_t bit = 1; bit < 8; bit *= 2) {
    for (std::size_t k = 0; k < 8; ++k) {
      if ((k & bit) == 0) piece.weight[k] -= piece.weight[k | bit];
    }
  }
  pieces_.push_back(piece);
  for (int i = 0; i < polygon.size; ++i) {
    add_edge(polygon.vertex[static_cast<std::size_t>(i)],
             polygon.vertex[static_cast<std::size_t>((i + 1) % polygon.size)]);
  }
}

/// An edge of a piece, walked with the outside of the mesh on the viewer's side. In the upper z
/// face the outward normal of the open part, times the length, is e_z × (to − from).
void CutCell::add_edge(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  if (from.z() != 1.0 || to.z() != 1.0) return;
  for (std::size_t s = 0; s < node3.size(); ++s) {
    const double x = from.x() + node3[s] * (to.x() - from.x());
    const double y = from.y() + node3[s] * (to.y() - from.y());
    const double w = weight3[s] * (to.x() - from.x()) * y;
    const std::array<double, 9> xy = plane_powers(x, y);
    for (std::size_t ab = 0; ab < 9; ++ab) {
      face_[ab] += w * xy[ab] / (1.0 + static_cast<double>(ab / 3));
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const double power = static_cast<double>(a) + 1.0;
    if (from.y() == 1.0) edge_[a] += std::pow(from.x(), power) / power;
    if (to.y() == 1.0) edge_[a] -= std::pow(to.x(), power) / power;
  }
}

std::optional<Corner> CutCell::corner() const {
  // With the corner outside all three are measures, else measures less that of the whole.
  const double face = face_[0] + edge_[0];
  const double sum = volume_[0] + face + face + edge_[0];
  if (std::abs(sum) < lost_to_rounding) return std::nullopt;
  return sum < 0.0 ? Corner::inside : Corner::outside;
}

Moments CutCell::volume(Corner corner) const {
  Moments volume = volume_;
  for (std::size_t a = 0; a < 3; ++a) {
    const double whole = corner == Corner::inside ? 1.0 / (static_cast<double>(a) + 1.0) : 0.0;
    const double edge = edge_[a] + whole;
    for (std::size_t b = 0; b < 3; ++b) {
      const double face = face_[a + 3 * b] + edge / (static_cast<double>(b) + 1.0);
      for (std::size_t c = 0; c < 3; ++c) {
        volume[a + 3 * b + 9 * c] += face / (static_cast<double>(c) + 1.0);
      }
    }
  }
  return volume;
}

}  // namespace kappamu::forward::embedded
