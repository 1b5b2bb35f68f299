// The directional dipole (J. R. Frisvad, T. Hachisuka, T. K. Kjeldsen, ACM TOG 34(1), 2014): the
// source is the refracted ray itself, diffusing from where it enters along its direction, and its
// image is mirrored in a plane turned perpendicular to x_o − x_i. The exitance depends on the
// direction of the light inside and on the normal where it leaves, so that no profile over the
// distance stands for it: it is summed over all pairs of triangles.
#pragma once

#include <vector>

#include "forward/analytic/half_space.h"
#include "forward/object_model.h"

namespace kappamu::forward::dipole {

/// Light that entered a triangle.
struct EnteredLight {
  double irradiance = 0.0;                              ///< after Fresnel reflection
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< mean of the unit vectors inside
};

/// Per triangle. Beams are refracted in; diffuse light has its mean direction along the normal.
/// Throws InputError where a beam arrives from inside.
std::vector<EnteredLight> entered_light(const ObjectProblem& problem, const ObjectLight& light);

class DirectionalDipole {
 public:
  DirectionalDipole(const Material& material, const BoundaryConstants& constants);

  /// Exitance at `to`, where the surface's normal is `to_normal`, per unit of power that entered at
  /// `from` in `direction` (of unit length or less: a mean) [1/mm²].
  double value(const Eigen::Vector3d& from, const Eigen::Vector3d& normal,
               const Eigen::Vector3d& direction, const Eigen::Vector3d& to,
               const Eigen::Vector3d& to_normal) const;
  double diffusion_coefficient() const { return D_; }  ///< smooth below this distance [mm]

 private:
  double of_ray(double r2, const Eigen::Vector3d& x, const Eigen::Vector3d& direction,
                const Eigen::Vector3d& to_normal) const;

  double D_ = 0.0, decay_ = 0.0;             ///< [mm], [1/mm]
  double depth_ = 0.0, image_ = 0.0;         ///< d_e and the image's height 2 A d_e [mm]
  double of_fluence_ = 0.0, of_flux_ = 0.0;  ///< C_φ, C_E
};

/// Exitance at the centroids; triangles near a receiver are split and integrated. Cost is the
/// square of the triangles. Equal bits on any number of cores.
std::vector<double> directional_sum(const TriangleMesh& mesh, const Surface& surface,
                                    const DirectionalDipole& dipole,
                                    const std::vector<EnteredLight>& light);

}  // namespace kappamu::forward::dipole
