// The true projector: what a point in space receives while the projector shows an image.
#pragma once

#include <Eigen/Core>

#include "calib/lens/lens.h"
#include "core/image.h"
#include "core/rigid.h"

namespace kappamu::synthetic {

struct ProjectorModel {
  calib::Lens lens;                   ///< with distortion
  Rigid projector_from_world;         ///< [mm]
  double black_level = 1.0 / 4500.0;  ///< light of a black pixel over that of a white one
  double gamma = 1.0;                 ///< light beyond black goes as value^gamma
  double defocus_px = 0.8;            ///< standard deviation of the Gaussian blur [projector px]
  /// Relative fall of intensity at the image's corner, growing with the square of the distance to
  /// its centre, on top of the lens's natural cos⁴ law.
  double falloff = 0.12;
  /// Sets the unit: irradiance of full white is 1 where `white_reference` called for it.
  double intensity = 1.0;
};

/// An image as the projector throws it: by its gamma, blurred, with the black level added; values
/// in [0, 1]. `shown` is grey, 0 dark and 1 full white, of the projector's size.
Image<float> thrown_image(const ProjectorModel& projector, const Image<float>& shown);

/// Where a point lies in the projector's image, and the irradiance it gets there from full white.
struct ProjectorSample {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double white = 0.0;  ///< 0 where the projector's light does not reach
};

/// `point` and the surface's unit `normal` are in the world frame. Radiant intensity towards θ off
/// the axis goes as cosθ (natural cos⁴ vignetting of the picture on a screen) times the falloff;
/// irradiance is that times cos of incidence / r².
ProjectorSample sample_projector(const ProjectorModel& projector, const Eigen::Vector3d& point,
                                 const Eigen::Vector3d& normal);

/// Bilinear in a thrown image; black beyond its edge.
double thrown_value(const Image<float>& thrown, const Eigen::Vector2d& pixel);

/// Sets `intensity` so that full white gives irradiance 1 at the point.
void set_white_reference(ProjectorModel& projector, const Eigen::Vector3d& point,
                         const Eigen::Vector3d& normal);

}  // namespace kappamu::synthetic
