#include "forward/light/voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kappamu::forward {

void Voxels::start(const Chord& chord) {
  start_ = (chord.from - corner_) / shape_.voxel_mm;
  direction_ = chord.direction;
  at_ = 0.0;
}

CellStep Voxels::step(double most) {
  const double far = most / shape_.voxel_mm, step_over = 1e-12 * (1.0 + at_ + far);
  const Eigen::Vector3d inside = start_ + (at_ + step_over) * direction_;
  std::array<int, 3> voxel{};
  double next = at_ + far;
  for (int axis = 0; axis < 3; ++axis) {
    const int i =
        std::clamp(static_cast<int>(std::floor(inside[axis])), 0, shape_.extent(axis) - 1);
    voxel[static_cast<std::size_t>(axis)] = i;
    const double along = direction_[axis];
    if (along != 0.0) next = std::min(next, (i + (along > 0.0 ? 1.0 : 0.0) - start_[axis]) / along);
  }
  next = std::max(next, at_ + step_over);
  CellStep step;
  step.cell = static_cast<int>(shape_.index(voxel[0], voxel[1], voxel[2]));
  step.length = std::min(most, (next - at_) * shape_.voxel_mm);
  at_ = next;
  return step;
}

}  // namespace kappamu::forward
