// What light inside meets on its way, and from outside: the triangles of an object, or a block's
// faces.
#pragma once

#include <array>

#include "core/grid.h"
#include "forward/object_model.h"

namespace kappamu::forward {

/// Snell's law for a direction that meets a surface against its normal; `eta_ratio` is the index
/// where it comes from over the one where it goes. Beyond the critical angle: along the surface.
Eigen::Vector3d refracted(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                          double eta_ratio);
/// By a mirror of this normal.
Eigen::Vector3d mirrored(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal);

/// Flat walls, each with a number. RayHit::triangle and Beam::triangle are such numbers.
class Walls {
 public:
  explicit Walls(double eta) : eta_(eta) {}
  virtual ~Walls() = default;

  double eta() const { return eta_; }
  /// Outwards.
  virtual const Eigen::Vector3d& normal(int wall) const = 0;
  /// The wall ahead of light inside that stands on a wall; takes it inwards where rounding took it
  /// out. None: it slips out along an edge.
  virtual std::optional<RayHit> inside(Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                                       int wall) const = 0;
  /// The wall ahead of light that is inside, away from all walls. None: it is on one, or outside.
  virtual std::optional<RayHit> ahead(const Eigen::Vector3d& position,
                                      const Eigen::Vector3d& direction) const = 0;
  /// Share of what arrives from inside, at a cosine to the normal, that goes out.
  virtual double transmitted(int wall, double cosine) const;

 private:
  double eta_;
};

/// The triangles of an object.
class MeshWalls final : public Walls {
 public:
  /// Refers to the problem's surface and rays.
  explicit MeshWalls(const ObjectProblem& problem);

  const Eigen::Vector3d& normal(int triangle) const override {
    return surface_.normal[static_cast<std::size_t>(triangle)];
  }
  std::optional<RayHit> inside(Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                               int triangle) const override;
  std::optional<RayHit> ahead(const Eigen::Vector3d& position,
                              const Eigen::Vector3d& direction) const override;
  double nudge() const { return nudge_; }  ///< [mm]
  /// A point of the surface, taken inwards and from the edges of its triangle by a way that rays
  /// tell from none.
  Eigen::Vector3d nudged(const Eigen::Vector3d& position, int triangle) const;
  /// The wall ahead of light that has left by a triangle.
  std::optional<RayHit> outside(const Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                                int triangle) const;

 private:
  std::optional<RayHit> off(const Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                            int triangle) const;

  const Surface& surface_;
  const RayCaster& rays_;
  double nudge_;
};

/// The six faces of a block in the sample frame (core/grid.h), numbered as all_faces has them.
class BoxWalls final : public Walls {
 public:
  /// `open`: false where a face is a mirror.
  BoxWalls(const GridShape& shape, double eta, const std::array<bool, 6>& open);

  const Eigen::Vector3d& normal(int face) const override {
    return normal_[static_cast<std::size_t>(face)];
  }
  std::optional<RayHit> inside(Eigen::Vector3d& position, const Eigen::Vector3d& direction,
                               int face) const override;
  std::optional<RayHit> ahead(const Eigen::Vector3d& position,
                              const Eigen::Vector3d& direction) const override;
  double transmitted(int face, double cosine) const override;

 private:
  Eigen::Vector3d far_;  ///< the corner of largest x, y, z [mm]
  std::array<bool, 6> open_;
  std::array<Eigen::Vector3d, 6> normal_;
};

}  // namespace kappamu::forward
