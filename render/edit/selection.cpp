#include "render/edit/selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "render/linear_image.h"

namespace kappamu::render {

namespace {

using Eigen::Vector3d;

/// Dabs of a stroke stand at most this share of the radius apart.
constexpr double dab_spacing = 0.25;
/// Of one selection; beyond, a stroke is too long for its radius to be meant.
constexpr double most_dabs = 1e6;

Vector3d centre(const GridShape& shape, int x, int y, int z) {
  return shape.voxel_mm * Vector3d(x + 0.5, y + 0.5, z + 0.5);
}

/// Every voxel with weight(x, y, z) above zero.
template <class Weight>
std::vector<SelectedVoxel> weighted(const GridShape& shape, const Weight& weight) {
  std::vector<SelectedVoxel> selected;
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const double w = weight(x, y, z);
        if (w > 0.0) {
          selected.push_back({static_cast<std::uint32_t>(shape.index(x, y, z)), std::min(w, 1.0)});
        }
      }
    }
  }
  return selected;
}

/// Layers between a voxel's centre and a face, the face's own layer at 0.5.
double layers_below(const GridShape& shape, Face face, int x, int y, int z) {
  const int axis = axis_of(face);
  const int at = axis == 0 ? x : axis == 1 ? y : z;
  return is_plus(face) ? shape.extent(axis) - at - 0.5 : at + 0.5;
}

class Brush {
 public:
  Brush(const BrushSelection& brush, const GridShape& shape)
      : brush_(brush), shape_(shape), weight_(shape.cells(), 0.0F) {
    const double reach = std::hypot(brush.radius_mm, brush.depth_mm);
    reach_ = Vector3d::Constant(reach).cwiseQuotient(brush.stretch);
  }

  void add(const Stroke& stroke) {
    const auto inward = [&](std::size_t i) {
      return stroke.inward[stroke.inward.size() == 1 ? 0 : i];
    };
    add_dab(stroke.points_mm[0], inward(0));
    for (std::size_t i = 1; i < stroke.points_mm.size(); ++i) {
      const Vector3d from = stroke.points_mm[i - 1], way = stroke.points_mm[i] - from;
      const double length = way.cwiseProduct(brush_.stretch).norm();
      const double dabs = std::ceil(length / (dab_spacing * brush_.radius_mm));
      dabs_ += dabs;
      if (dabs_ > most_dabs) {
        throw InputError(
            "the strokes are more than 250,000 radii long; widen the brush or shorten "
            "them");
      }
      for (int dab = 1; dab <= dabs; ++dab) {
        const double at = dab / dabs;
        const Vector3d axis = (1.0 - at) * inward(i - 1) + at * inward(i);
        add_dab(from + at * way, axis.norm() > 1e-6 ? axis.normalized() : inward(i));
      }
    }
  }

  std::vector<SelectedVoxel> selected() const {
    return weighted(shape_, [&](int x, int y, int z) {
      return static_cast<double>(weight_[shape_.index(x, y, z)]);
    });
  }

 private:
  void add_dab(const Vector3d& point, const Vector3d& inward) {
    const auto first = [&](int axis) {
      const double at = (point[axis] - reach_[axis]) / shape_.voxel_mm;
      return static_cast<int>(std::clamp(std::floor(at), 0.0, 1.0 * shape_.extent(axis)));
    };
    const auto end = [&](int axis) {
      const double at = (point[axis] + reach_[axis]) / shape_.voxel_mm;
      return static_cast<int>(std::clamp(std::ceil(at), 0.0, 1.0 * shape_.extent(axis)));
    };
    for (int z = first(2); z < end(2); ++z) {
      for (int y = first(1); y < end(1); ++y) {
        for (int x = first(0); x < end(0); ++x) {
          const Vector3d from_point =
              (centre(shape_, x, y, z) - point).cwiseProduct(brush_.stretch);
          float& weight = weight_[shape_.index(x, y, z)];
          weight = std::max(weight, weight_of(from_point, inward));
        }
      }
    }
  }

  float weight_of(const Vector3d& from_point, const Vector3d& inward) const {
    const double depth = from_point.dot(inward);
    // Half a voxel outwards: where the surface cuts a voxel, its centre may lie outside.
    const double half_voxel = 0.5 * shape_.voxel_mm * brush_.stretch.maxCoeff();
    if (depth < -half_voxel || depth > brush_.depth_mm) return 0.0F;
    const double aside = (from_point - depth * inward).norm() / brush_.radius_mm;
    if (aside >= 1.0) return 0.0F;
    if (aside <= brush_.hardness) return 1.0F;
    const double fall = (aside - brush_.hardness) / (1.0 - brush_.hardness);
    return static_cast<float>(0.5 + 0.5 * std::cos(std::numbers::pi * fall));
  }

  const BrushSelection& brush_;
  const GridShape& shape_;
  std::vector<float> weight_;
  Vector3d reach_;     ///< of a dab, along the axes [mm of the volume]
  double dabs_ = 0.0;  ///< between the points of the strokes so far
};

std::vector<SelectedVoxel> selected(const WholeSelection& /*where*/, const GridShape& shape) {
  return weighted(shape, [](int, int, int) { return 1.0; });
}

std::vector<SelectedVoxel> selected(const BrushSelection& where, const GridShape& shape) {
  Brush brush(where, shape);
  for (const Stroke& stroke : where.strokes) brush.add(stroke);
  return brush.selected();
}

std::vector<SelectedVoxel> selected(const TextureSelection& where, const GridShape& shape) {
  const Image<float> image = read_linear_image(where.image);
  const FaceShape face = face_shape(shape, where.face);
  const int axis = axis_of(where.face);
  return weighted(shape, [&](int x, int y, int z) {
    if (layers_below(shape, where.face, x, y, z) * shape.voxel_mm > where.depth_mm) return 0.0;
    const int u = axis == 0 ? y : x, v = axis == 2 ? y : z;
    const int column = static_cast<int>((u + 0.5) / face.nu * image.width());
    const int row = static_cast<int>((face.nv - v - 0.5) / face.nv * image.height());
    return luminance(
        pixel(image, std::min(column, image.width() - 1), std::min(row, image.height() - 1)));
  });
}

std::vector<SelectedVoxel> selected(const DepthSelection& where, const GridShape& shape) {
  return weighted(shape, [&](int x, int y, int z) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Face face : where.faces) {
      nearest = std::min(nearest, layers_below(shape, face, x, y, z) * shape.voxel_mm);
    }
    return nearest >= where.from_mm && nearest < where.to_mm ? 1.0 : 0.0;
  });
}

std::vector<SelectedVoxel> selected(const BoxSelection& where, const GridShape& shape) {
  return weighted(shape, [&](int x, int y, int z) {
    const Vector3d at = centre(shape, x, y, z);
    return (at.array() >= where.from_mm.array()).all() && (at.array() <= where.to_mm.array()).all()
               ? 1.0
               : 0.0;
  });
}

}  // namespace

std::vector<SelectedVoxel> select(const Selection& where, const GridShape& shape) {
  return std::visit([&](const auto& kind) { return selected(kind, shape); }, where);
}

}  // namespace kappamu::render
