#include "render/edit/selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "render/linear_image.h"
#include "render/look_at.h"

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

/// The weights that a selection has gathered, in the order of the voxels.
std::vector<SelectedVoxel> above_zero(const std::vector<float>& weight) {
  std::vector<SelectedVoxel> selected;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    if (weight[i] > 0.0F) {
      selected.push_back({static_cast<std::uint32_t>(i), std::min<double>(weight[i], 1.0)});
    }
  }
  return selected;
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

const EditedBody& required(const EditedBody* body) {
  if (body) return *body;
  throw InputError(
      "its place is in the frame of an object, and there is none; write a place in the volume's "
      "frame");
}

/// Every voxel by weight(place in the object), the largest of those that it has there.
template <class Weight>
std::vector<SelectedVoxel> weighted_in(const EditedBody& body, const GridShape& shape,
                                       const Weight& weight) {
  std::vector<float> weights(shape.cells(), 0.0F);
  for (const Eigen::Affine3d& image : body.images()) {
    for_rows(shape.ny * shape.nz, [&](int row) {
      const int y = row % shape.ny, z = row / shape.ny;
      for (int x = 0; x < shape.nx; ++x) {
        float& here = weights[shape.index(x, y, z)];
        here = std::max(here, static_cast<float>(weight(image * centre(shape, x, y, z))));
      }
    });
  }
  return above_zero(weights);
}

/// The same by weight(EditedBody::Below) of places down to a depth below the surface. A surface
/// cuts voxels: their centres lie outside, at most half a diagonal, and count as of depth 0.
template <class Weight>
std::vector<SelectedVoxel> weighted_below(const EditedBody& body, const GridShape& shape,
                                          double from_mm, double to_mm, const Weight& weight) {
  constexpr int block = 4;  // voxels that are looked at only where their middle lies near
  const auto blocks = [](int n) { return (n + block - 1) / block; };
  const int nx = blocks(shape.nx), ny = blocks(shape.ny), nz = blocks(shape.nz);
  std::vector<float> weights(shape.cells(), 0.0F);
  for (const Eigen::Affine3d& image : body.images()) {
    const double diagonal = shape.voxel_mm * image.linear().colwise().norm().norm();
    const double outside = 0.5 * diagonal, radius = 0.5 * block * diagonal;
    const auto look = [&](int x, int y, int z) {
      EditedBody::Below place = body.below(image * centre(shape, x, y, z));
      if (place.depth < -outside) return;
      place.depth = std::max(place.depth, 0.0);
      if (place.depth < from_mm || place.depth >= to_mm) return;
      float& here = weights[shape.index(x, y, z)];
      here = std::max(here, static_cast<float>(weight(place)));
    };
    for_rows(nx * ny * nz, [&](int row) {
      const Eigen::Vector3i at = block * Eigen::Vector3i(row % nx, row / nx % ny, row / nx / ny);
      const Vector3d middle = shape.voxel_mm * (at.cast<double>().array() + 0.5 * block);
      const double depth = body.below(image * middle).depth;
      if (depth < -outside - radius || depth < from_mm - radius || depth > to_mm + radius) return;
      for (int z = at.z(); z < std::min(at.z() + block, shape.nz); ++z) {
        for (int y = at.y(); y < std::min(at.y() + block, shape.ny); ++y) {
          for (int x = at.x(); x < std::min(at.x() + block, shape.nx); ++x) look(x, y, z);
        }
      }
    });
  }
  return above_zero(weights);
}

/// Layers between a voxel's centre and a face, the face's own layer at 0.5.
double layers_below(const GridShape& shape, Face face, int x, int y, int z) {
  const int axis = axis_of(face);
  const int at = axis == 0 ? x : axis == 1 ? y : z;
  return is_plus(face) ? shape.extent(axis) - at - 0.5 : at + 0.5;
}

class Brush {
 public:
  /// `painted_from_volume` leads to millimetres of the painted object; places of strokes are in the
  /// frame that it leads to, or in the volume's where `frame` says so.
  Brush(const BrushSelection& brush, const GridShape& shape,
        const Eigen::Affine3d& painted_from_volume, std::vector<float>& weight)
      : brush_(brush), shape_(shape), metric_(painted_from_volume.linear()), weight_(weight) {
    if (brush.frame == Frame::object) volume_from_points_ = painted_from_volume.inverse();
    const double reach = std::hypot(brush.radius_mm, brush.depth_mm);
    reach_ = metric_.inverse().cwiseAbs() * Vector3d::Constant(reach);
    half_voxel_ = 0.5 * shape.voxel_mm * metric_.colwise().norm().maxCoeff();
  }

  void add(const Stroke& stroke) {
    const auto inward = [&](std::size_t i) {
      return stroke.inward[stroke.inward.size() == 1 ? 0 : i];
    };
    const auto point = [&](std::size_t i) -> Vector3d {
      return volume_from_points_ * stroke.points_mm[i];
    };
    add_dab(point(0), inward(0));
    for (std::size_t i = 1; i < stroke.points_mm.size(); ++i) {
      const Vector3d from = point(i - 1), way = point(i) - from;
      const double length = (metric_ * way).norm();
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

 private:
  /// `point` is in the volume's frame, `inward` in the painted object's.
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
          const Vector3d from_point = metric_ * (centre(shape_, x, y, z) - point);
          float& weight = weight_[shape_.index(x, y, z)];
          weight = std::max(weight, weight_of(from_point, inward));
        }
      }
    }
  }

  float weight_of(const Vector3d& from_point, const Vector3d& inward) const {
    const double depth = from_point.dot(inward);
    // Half a voxel outwards: where the surface cuts a voxel, its centre may lie outside.
    if (depth < -half_voxel_ || depth > brush_.depth_mm) return 0.0F;
    const double aside = (from_point - depth * inward).norm() / brush_.radius_mm;
    if (aside >= 1.0) return 0.0F;
    if (aside <= brush_.hardness) return 1.0F;
    const double fall = (aside - brush_.hardness) / (1.0 - brush_.hardness);
    return static_cast<float>(0.5 + 0.5 * std::cos(std::numbers::pi * fall));
  }

  const BrushSelection& brush_;
  const GridShape& shape_;
  Eigen::Matrix3d metric_;  ///< from the volume's millimetres to those of the painted object
  Eigen::Affine3d volume_from_points_ = Eigen::Affine3d::Identity();
  std::vector<float>& weight_;
  Vector3d reach_;           ///< of a dab, along the axes [mm of the volume]
  double half_voxel_ = 0.0;  ///< [mm of the painted object]
  double dabs_ = 0.0;        ///< between the points of the strokes so far
};

std::vector<SelectedVoxel> selected(const WholeSelection& /*where*/, const GridShape& shape,
                                    const EditedBody* /*body*/) {
  return weighted(shape, [](int, int, int) { return 1.0; });
}

std::vector<SelectedVoxel> selected(const BrushSelection& where, const GridShape& shape,
                                    const EditedBody* body) {
  std::vector<Eigen::Affine3d> images;
  if (where.frame == Frame::object) {
    images = required(body).images();
  } else {
    images = {Eigen::Affine3d(where.stretch.asDiagonal())};
  }
  std::vector<float> weight(shape.cells(), 0.0F);
  for (const Eigen::Affine3d& image : images) {
    Brush brush(where, shape, image, weight);
    for (const Stroke& stroke : where.strokes) brush.add(stroke);
  }
  return above_zero(weight);
}

/// Of the pixel at (x, y) in [0, 1]², from the top left corner.
double luminance_at(const Image<float>& image, double x, double y) {
  const int column = static_cast<int>(x * image.width()),
            row = static_cast<int>(y * image.height());
  return luminance(
      pixel(image, std::min(column, image.width() - 1), std::min(row, image.height() - 1)));
}

std::vector<SelectedVoxel> selected(const TextureSelection& where, const GridShape& shape,
                                    const EditedBody* /*body*/) {
  const Image<float> image = read_linear_image(where.image);
  const FaceShape face = face_shape(shape, where.face);
  const int axis = axis_of(where.face);
  return weighted(shape, [&](int x, int y, int z) {
    if (layers_below(shape, where.face, x, y, z) * shape.voxel_mm > where.depth_mm) return 0.0;
    const int u = axis == 0 ? y : x, v = axis == 2 ? y : z;
    return luminance_at(image, (u + 0.5) / face.nu, (face.nv - v - 0.5) / face.nv);
  });
}

std::vector<SelectedVoxel> selected(const ProjectionSelection& where, const GridShape& shape,
                                    const EditedBody* body) {
  const EditedBody& lit = required(body);
  const Image<float> image = read_linear_image(where.image);
  const LookAt look(where.position_mm, where.target_mm, where.up, where.fov_deg,
                    static_cast<double>(image.width()) / image.height());
  return weighted_below(lit, shape, where.from_mm, where.to_mm,
                        [&](const EditedBody::Below& place) {
                          double x = 0.0, y = 0.0;
                          if (!look.image_point(place.surface - where.position_mm, x, y))
                            return 0.0;
                          const double weight = luminance_at(image, x, y);
                          return weight > 0.0 && lit.sees(where.position_mm, place) ? weight : 0.0;
                        });
}

std::vector<SelectedVoxel> selected(const CoordinatesSelection& where, const GridShape& shape,
                                    const EditedBody* body) {
  const EditedBody& lit = required(body);
  if (!lit.has_texture()) {
    throw InputError(
        "its image lies by texture coordinates, and the object's mesh has none; project it from a "
        "place, or write them into the mesh");
  }
  const Image<float> image = read_linear_image(where.image);
  const auto within = [](double value) { return value - std::floor(value); };
  return weighted_below(lit, shape, where.from_mm, where.to_mm,
                        [&](const EditedBody::Below& place) {
                          const Eigen::Vector2d at = lit.texture_at(place);
                          return luminance_at(image, within(at.x()), within(1.0 - at.y()));
                        });
}

std::vector<SelectedVoxel> selected(const DepthSelection& where, const GridShape& shape,
                                    const EditedBody* body) {
  if (where.frame == Frame::object) {
    return weighted_below(required(body), shape, where.from_mm, where.to_mm,
                          [](const EditedBody::Below& /*place*/) { return 1.0; });
  }
  return weighted(shape, [&](int x, int y, int z) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Face face : where.faces) {
      nearest = std::min(nearest, layers_below(shape, face, x, y, z) * shape.voxel_mm);
    }
    return nearest >= where.from_mm && nearest < where.to_mm ? 1.0 : 0.0;
  });
}

std::vector<SelectedVoxel> selected(const BoxSelection& where, const GridShape& shape,
                                    const EditedBody* body) {
  const auto weight = [&](const Vector3d& at) {
    const bool inside =
        (at.array() >= where.from_mm.array()).all() && (at.array() <= where.to_mm.array()).all();
    return inside ? 1.0 : 0.0;
  };
  if (where.frame == Frame::object) return weighted_in(required(body), shape, weight);
  return weighted(shape, [&](int x, int y, int z) { return weight(centre(shape, x, y, z)); });
}

}  // namespace

std::vector<SelectedVoxel> select(const Selection& where, const GridShape& shape,
                                  const EditedBody* body) {
  return std::visit([&](const auto& kind) { return selected(kind, shape, body); }, where);
}

}  // namespace kappamu::render
