// Pictures of planar surfaces: what the camera sees of boards, chart, white target and the sample,
// as noise-free radiance. Radiances are per white irradiance and steradian; the sensor's gain comes
// later.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "calib/lens/lens.h"
#include "core/grid.h"
#include "core/image.h"
#include "core/optics.h"
#include "core/rigid.h"
#include "data_synthetic/rig/projector_light.h"

namespace kappamu::synthetic {

/// Directions of a lens's supersampled rays, found once for all pictures.
class RayTable {
 public:
  /// `per_side`² rays per pixel on a regular lattice.
  RayTable(const calib::Lens& lens, int per_side);

  int width() const { return width_; }
  int height() const { return height_; }
  int per_pixel() const { return per_side_ * per_side_; }
  int per_side() const { return per_side_; }
  double focal_px() const { return focal_px_; }
  /// Direction (x', y', 1) in the camera frame of ray `n` of pixel (x, y).
  Eigen::Vector3d direction(int x, int y, int n) const {
    const std::array<float, 2>& d =
        directions_[(static_cast<std::size_t>(y) * width_ + x) * per_pixel() + n];
    return {d[0], d[1], 1.0};
  }

 private:
  int width_;
  int height_;
  int per_side_;
  double focal_px_;
  std::vector<std::array<float, 2>> directions_;
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

/// The glowing face of the sample through one camera: where each ray meets the face, found once for
/// all patterns.
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
  int width_;
  int height_;
  int per_pixel_;
  FaceShape shape_;
  std::vector<float> factor_;                   ///< [y][x] radiance per exitance [1/sr]
  std::vector<std::array<float, 2>> position_;  ///< [y][x][ray] in cells, u < 0: beside the face
};

}  // namespace kappamu::synthetic
