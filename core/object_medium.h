// κ and μ at every point of an object: one pair of coefficients, or a measured volume placed in the
// object's frame.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "core/grid.h"

namespace kappamu {

struct Coefficients {
  double kappa = 0.0;  ///< diffusion coefficient [mm]
  double mu = 0.0;     ///< absorption coefficient [1/mm]
};

/// What a placed volume is beyond its own box.
enum class Wrap {
  clamp,   ///< its nearest voxel
  repeat,  ///< the volume again
  mirror   ///< the volume again, every other one mirrored
};

class ObjectMedium {
 public:
  /// The same coefficients everywhere.
  explicit ObjectMedium(const Coefficients& coefficients);
  /// Piecewise constant on voxels. `volume_from_object` maps a point of the object [mm] to the
  /// volume's own frame [mm] (core/grid.h); it may stretch, coefficients stay what they are.
  ObjectMedium(std::shared_ptr<const Medium> volume, const Eigen::Affine3d& volume_from_object,
               Wrap wrap);

  bool homogeneous() const { return !volume_; }
  Coefficients at(const Eigen::Vector3d& point) const;
  /// Whether both are volumes whose voxels lie in the same places.
  bool placed_as(const ObjectMedium& other) const;
  /// Of a volume: the voxel that holds a point, and the coefficients of one.
  std::size_t voxel_at(const Eigen::Vector3d& point) const;
  Coefficients of_voxel(std::size_t voxel) const {
    return {volume_->kappa[voxel], volume_->mu[voxel]};
  }
  /// A box [mm] outside of which this medium is the same as `other`: empty where they are the same
  /// everywhere, all of space where they are not placed alike.
  Eigen::AlignedBox3d difference(const ObjectMedium& other) const;
  /// Smallest and largest of each coefficient over the whole medium.
  Coefficients smallest() const { return smallest_; }
  Coefficients largest() const { return largest_; }
  /// Shortest voxel edge as it lies in the object [mm]; none where homogeneous.
  std::optional<double> voxel_mm() const { return voxel_mm_; }

 private:
  std::shared_ptr<const Medium> volume_;
  Eigen::Affine3d volume_from_object_ = Eigen::Affine3d::Identity();
  Wrap wrap_ = Wrap::clamp;
  Coefficients smallest_, largest_;
  std::optional<double> voxel_mm_;
};

}  // namespace kappamu
