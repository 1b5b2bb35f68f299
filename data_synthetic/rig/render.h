// Pictures of planar surfaces: what the camera sees of boards, chart, white target and the sample,
// as noise-free radiance. Radiances are per white irradiance and steradian; the sensor's gain comes
// later.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "calib/lens/lens.h"
#include "core/grid.h"
#include "core/image.h"
#include "core/optics.h"
#include "core/rigid.h"
#include "data_synthetic/rig/projector_light.h"

namespace kappamu::synthetic {

/// A lens's supersampled rays, `per_side`² per pixel on a regular lattice. Directions are (x', y',
/// 1) in the camera frame.
class RayTable {
 public:
  RayTable(const calib::Lens& lens, int per_side);

  int width() const { return lens_.width; }
  int height() const { return lens_.height; }
  int per_pixel() const { return per_side_ * per_side_; }
  int per_side() const { return per_side_; }
  double focal_px() const { return 0.5 * (lens_.fx + lens_.fy); }
  /// [px] Edge of the squares within which what a plane shows is interpolated between the corners:
  /// a lens and a perspective bend a few 1e-4 px at most there.
  int tile() const { return tile_; }
  Eigen::Vector3d direction(const Eigen::Vector2d& pixel) const { return lens_.unproject(pixel); }
  /// Through the corner where the squares of that column and row begin; known without undistorting.
  const Eigen::Vector3d& corner(int column, int row) const {
    return (*corners_)[static_cast<std::size_t>(row) * corners_in_row() +
                       static_cast<std::size_t>(column)];
  }
  /// Of ray n from its pixel's centre [px].
  Eigen::Vector2d offset(int n) const {
    return {(n % per_side_ + 0.5) / per_side_ - 0.5, (n / per_side_ + 0.5) / per_side_ - 0.5};
  }

 private:
  std::size_t corners_in_row() const {
    return static_cast<std::size_t>((lens_.width + tile_ - 1) / tile_) + 1;
  }

  calib::Lens lens_;
  int per_side_;
  int tile_;
  std::shared_ptr<const std::vector<Eigen::Vector3d>> corners_;  ///< copies share them
};

/// Diffuse reflectances R, G, B of a surface at (x, y) [mm], averaged over the extent of one ray
/// along x and y, `footprint` [mm].
using Albedo = std::function<std::array<double, 3>(const Eigen::Vector2d& position,
                                                   const Eigen::Vector2d& footprint)>;

/// A textured rectangle in the plane z = 0 of its own frame, seen from its -z side.
struct Quad {
  Rigid world_from_quad;
  Eigen::Vector2d low = Eigen::Vector2d::Zero();   ///< corner with the smallest x, y [mm]
  Eigen::Vector2d high = Eigen::Vector2d::Zero();  ///< corner with the largest x, y [mm]
  Albedo albedo;
};

struct Illumination {
  double ambient = 0.0;  ///< irradiance of even light from everywhere
  const ProjectorModel* projector = nullptr;
  const Image<float>* thrown = nullptr;  ///< thrown_image(); null: the projector is off
};

/// Radiance [y][x][3] = albedo · irradiance / π of the quads, listed from front to back; black
/// beside all of them. Quads do not shade each other.
Image<float> render_quads(const RayTable& rays, const Rigid& world_from_camera,
                          const std::vector<Quad>& quads, const Illumination& light);

/// Fraction of a filter `width` wide, centred on `position`, that lies between `low` and `high`.
double coverage(double position, double low, double high, double width);

/// The glowing face of the sample through one camera.
class FaceView {
 public:
  FaceView(const RayTable& rays, const Rigid& world_from_camera, const Rigid& world_from_sample,
           const GridShape& surface, Face face, const BoundaryConstants& constants);

  /// Radiance [y][x][C] for exitance maps [channel][v][u] on the surface's cells: bilinear between
  /// cell centres and linear beyond the outermost, times the P1 radiance per exitance at each
  /// pixel's angle; black beside the face.
  Image<float> radiance(const std::vector<std::vector<double>>& exitance) const;

  /// Whether the whole pixel lies on the face.
  bool covers(int x, int y) const;

 private:
  struct Place {
    double u = 0.0, v = 0.0;  ///< in cells
    double cosine = 0.0;      ///< of the ray with the face's outward normal
  };
  Place place(const Eigen::Vector3d& direction) const;

  RayTable rays_;
  Rigid sample_from_camera_;
  FaceShape shape_;
  double voxel_mm_, plane_z_, outward_;
  BoundaryConstants constants_;
};

}  // namespace kappamu::synthetic
