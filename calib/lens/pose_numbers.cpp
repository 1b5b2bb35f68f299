#include "calib/lens/pose_numbers.h"

#include <Eigen/Geometry>

namespace kappamu::calib {

std::array<double, 6> six_of(const Rigid& motion) {
  const Eigen::AngleAxisd turn(motion.rotation);
  const Eigen::Vector3d vector = turn.angle() * turn.axis();
  const Eigen::Vector3d& t = motion.translation;
  return {vector.x(), vector.y(), vector.z(), t.x(), t.y(), t.z()};
}

Rigid rigid_of(const std::array<double, 6>& six) {
  const Eigen::Vector3d vector(six[0], six[1], six[2]);
  const double angle = vector.norm();
  Rigid motion;
  if (angle > 0.0) motion.rotation = Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
  motion.translation = {six[3], six[4], six[5]};
  return motion;
}

}  // namespace kappamu::calib
