#include "forward/embedded/cut_cell.h"

#include <Eigen/Geometry>
#include <cmath>

namespace kappamu::forward::embedded {

namespace {

// Gauss-Legendre rules on [0, 1]: exact to degree 5, 7 and 9.
constexpr std::array<double, 3> node3{0.1127016653792583, 0.5, 0.8872983346207417};
constexpr std::array<double, 3> weight3{0.2777777777777778, 0.4444444444444444, 0.2777777777777778};
constexpr std::array<double, 4> node4{0.0694318442029737, 0.3300094782075719, 0.6699905217924281,
                                      0.9305681557970263};
constexpr std::array<double, 4> weight4{0.1739274225687269, 0.3260725774312731, 0.3260725774312731,
                                        0.1739274225687269};
constexpr std::array<double, 5> node5{0.0469100770306680, 0.2307653449471585, 0.5,
                                      0.7692346550528415, 0.9530899229693320};
constexpr std::array<double, 5> weight5{0.1184634425280945, 0.2393143352496832, 0.2844444444444444,
                                        0.2393143352496832, 0.1184634425280945};

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
  SurfacePiece piece;
  piece.triangle = triangle;
  double area = 0.0;
  for (std::size_t i = 1; i + 1 < static_cast<std::size_t>(polygon.size); ++i) {
    const Eigen::Vector3d& p = polygon.vertex[0];
    const Eigen::Vector3d u = polygon.vertex[i] - p;
    const Eigen::Vector3d v = polygon.vertex[i + 1] - polygon.vertex[i];
    const double doubled = u.cross(v).norm();
    if (!(doubled > 0.0)) continue;
    area += doubled;
    for (std::size_t s = 0; s < node5.size(); ++s) {
      for (std::size_t t = 0; t < node4.size(); ++t) {
        // The square (s, t) collapsed onto the triangle: p + s (u + t v), with Jacobian s.
        const Eigen::Vector3d x = p + node5[s] * (u + node4[t] * v);
        const double w = weight5[s] * weight4[t] * node5[s] * doubled;
        const std::array<double, 9> xy = plane_powers(x.x(), x.y());
        const double z = x.z(), wn = w * normal.z() * z;
        const std::array<double, 3> on_surface{w, w * z, w * z * z};
        const std::array<double, 3> in_volume{wn, wn * z / 2.0, wn * z * z / 3.0};
        for (std::size_t c = 0; c < 3; ++c) {
          for (std::size_t ab = 0; ab < 9; ++ab) {
            surface_[9 * c + ab] += on_surface[c] * xy[ab];
            volume_[9 * c + ab] += in_volume[c] * xy[ab];
          }
        }
        for (std::size_t k = 0; k < 8; ++k) {
          piece.weight[k] += w * ((k & 1) ? x.x() : 1.0 - x.x()) *
                             ((k & 2) ? x.y() : 1.0 - x.y()) * ((k & 4) ? z : 1.0 - z);
        }
      }
    }
  }
  if (!(area > 0.0)) return;
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

std::optional<bool> CutCell::corner_inside() const {
  // With the corner outside all three are measures, else measures less that of the whole.
  const double face = face_[0] + edge_[0];
  const double sum = volume_[0] + face + face + edge_[0];
  if (std::abs(sum) < lost_to_rounding) return std::nullopt;
  return sum < 0.0;
}

Moments CutCell::volume(bool corner_inside) const {
  Moments volume = volume_;
  for (std::size_t a = 0; a < 3; ++a) {
    const double edge = edge_[a] + (corner_inside ? 1.0 / (static_cast<double>(a) + 1.0) : 0.0);
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
