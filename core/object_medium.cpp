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
  return volume_ ? of_voxel(voxel_at(point)) : smallest_;
}

std::size_t ObjectMedium::voxel_at(const Eigen::Vector3d& point) const {
  const GridShape& s = volume_->kappa.shape();
  const Eigen::Vector3d voxel = (volume_from_object_ * point) / s.voxel_mm;
  return s.index(wrapped(voxel.x(), s.nx, wrap_), wrapped(voxel.y(), s.ny, wrap_),
                 wrapped(voxel.z(), s.nz, wrap_));
}

bool ObjectMedium::placed_as(const ObjectMedium& other) const {
  return volume_ && other.volume_ && other.wrap_ == wrap_ &&
         other.volume_->kappa.shape() == volume_->kappa.shape() &&
         other.volume_from_object_.matrix() == volume_from_object_.matrix();
}

Eigen::AlignedBox3d ObjectMedium::difference(const ObjectMedium& other) const {
  constexpr double far = 1e9;  // [mm]
  const Eigen::AlignedBox3d everywhere(Eigen::Vector3d::Constant(-far),
                                       Eigen::Vector3d::Constant(far));
  if (!volume_ && !other.volume_ && smallest_.kappa == other.smallest_.kappa &&
      smallest_.mu == other.smallest_.mu) {
    return {};
  }
  if (!volume_ || !other.volume_) return everywhere;
  const GridShape& s = volume_->kappa.shape();
  if (wrap_ != Wrap::clamp || !placed_as(other)) return everywhere;
  if (volume_ == other.volume_) return {};
  Eigen::AlignedBox3i voxels;
  const auto same = [&](const Medium& a, const Medium& b, std::size_t i) {
    return a.kappa[i] == b.kappa[i] && a.mu[i] == b.mu[i];
  };
  for (int z = 0; z < s.nz; ++z) {
    for (int y = 0; y < s.ny; ++y) {
      for (int x = 0; x < s.nx; ++x) {
        if (!same(*volume_, *other.volume_, s.index(x, y, z))) {
          voxels.extend(Eigen::Vector3i(x, y, z));
        }
      }
    }
  }
  if (voxels.isEmpty()) return {};
  // The outermost voxels go on beyond the volume.
  Eigen::AlignedBox3d box(s.voxel_mm * voxels.min().cast<double>(),
                          s.voxel_mm * (voxels.max().array() + 1).matrix().cast<double>());
  for (int axis = 0; axis < 3; ++axis) {
    if (voxels.min()[axis] == 0) box.min()[axis] = -far;
    if (voxels.max()[axis] == s.extent(axis) - 1) box.max()[axis] = far;
  }
  return box.transformed(volume_from_object_.inverse());
}

}  // namespace kappamu
