#include "core/object_medium.h"

#include <algorithm>
#include <cmath>

namespace kappamu {

namespace {

/// Index of the voxel that stands at position `x` in voxels on an axis of `count`.
int wrapped(double x, int count, Wrap wrap) {
  if (wrap == Wrap::clamp) return static_cast<int>(std::clamp(std::floor(x), 0.0, count - 1.0));
  const int period = wrap == Wrap::repeat ? count : 2 * count;
  int index = static_cast<int>(std::floor(x - period * std::floor(x / period)));
  index = std::clamp(index, 0, period - 1);  // x just below a multiple rounds up to the period
  return index < count ? index : period - 1 - index;
}

}  // namespace

ObjectMedium::ObjectMedium(const Coefficients& coefficients)
    : smallest_(coefficients), largest_(coefficients) {}

ObjectMedium::ObjectMedium(std::shared_ptr<const Medium> volume,
                           const Eigen::Affine3d& volume_from_object, Wrap wrap)
    : volume_(std::move(volume)), volume_from_object_(volume_from_object), wrap_(wrap) {
  const auto [kappa_low, kappa_high] =
      std::minmax_element(volume_->kappa.values().begin(), volume_->kappa.values().end());
  const auto [mu_low, mu_high] =
      std::minmax_element(volume_->mu.values().begin(), volume_->mu.values().end());
  smallest_ = {*kappa_low, *mu_low};
  largest_ = {*kappa_high, *mu_high};
  const Eigen::Matrix3d object_from_volume = volume_from_object_.linear().inverse();
  voxel_mm_ = volume_->kappa.shape().voxel_mm * object_from_volume.colwise().norm().minCoeff();
}

Coefficients ObjectMedium::at(const Eigen::Vector3d& point) const {
  if (!volume_) return smallest_;
  const GridShape& s = volume_->kappa.shape();
  const Eigen::Vector3d voxel = (volume_from_object_ * point) / s.voxel_mm;
  const std::size_t i = s.index(wrapped(voxel.x(), s.nx, wrap_), wrapped(voxel.y(), s.ny, wrap_),
                                wrapped(voxel.z(), s.nz, wrap_));
  return {volume_->kappa[i], volume_->mu[i]};
}

}  // namespace kappamu
