#include "forward/dipole/directional.h"

#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "forward/dipole/form_factor/quadrature.h"
#include "forward/light_entry.h"

namespace kappamu::forward::dipole {

namespace {

/// Size of a triangle over its distance beyond which it is split, and below which its centroid
/// stands for it.
constexpr double splits_beyond = 0.5, point_below = 0.1;
constexpr int most_splits = 5;

/// Mean cosine to the normal, inside, of diffuse light that was refracted in.
double mean_cosine(double eta) {
  constexpr int points = 400;
  const double least = std::sqrt(1.0 - 1.0 / (eta * eta));
  double flux = 0.0, along = 0.0;
  for (int i = 0; i < points; ++i) {
    const double cosine = least + (1.0 - least) * (i + 0.5) / points;
    const double passes = (1.0 - fresnel_internal(eta, cosine)) * cosine;
    flux += passes;
    along += passes * cosine;
  }
  return along / flux;
}

double integrated(const DirectionalDipole& dipole, const Corners& corners,
                  const Eigen::Vector3d& normal, const Eigen::Vector3d& direction,
                  const Eigen::Vector3d& to, const Eigen::Vector3d& to_normal, int splits) {
  const Eigen::Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3.0;
  const double size = std::max({(corners[0] - corners[1]).norm(), (corners[1] - corners[2]).norm(),
                                (corners[2] - corners[0]).norm()});
  const double distance = std::hypot((to - middle).norm(), dipole.diffusion_coefficient());
  const auto at = [&](const Eigen::Vector3d& from) {
    return dipole.value(from, normal, direction, to, to_normal);
  };
  if (size < point_below * distance)
    return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() * at(middle);
  if (size < splits_beyond * distance || splits == most_splits) return triangle_rule(corners, at);
  const Eigen::Vector3d a = 0.5 * (corners[1] + corners[2]), b = 0.5 * (corners[2] + corners[0]),
                        c = 0.5 * (corners[0] + corners[1]);
  double sum = 0.0;
  for (const Corners& part : {Corners{corners[0], c, b}, Corners{c, corners[1], a},
                              Corners{b, a, corners[2]}, Corners{a, b, c}}) {
    sum += integrated(dipole, part, normal, direction, to, to_normal, splits + 1);
  }
  return sum;
}

}  // namespace

std::vector<EnteredLight> entered_light(const ObjectProblem& problem, const ObjectLight& light) {
  const Surface& surface = problem.surface;
  std::vector<EnteredLight> entered(surface.size());
  const double diffuse = diffuse_transmittance(boundary_constants(problem.eta));
  const double cosine = mean_cosine(problem.eta);
  for (std::size_t t = 0; t < light.diffuse.size(); ++t) {
    entered[t].irradiance = diffuse * light.diffuse[t];
    entered[t].direction = -cosine * entered[t].irradiance * surface.normal[t];
  }
  const double size = bounding_box(problem.mesh).sizes().maxCoeff();
  for (const Beam& beam : light.beams) {
    const auto t = static_cast<std::size_t>(beam.triangle);
    const BeamPath path = enter(problem, beam, size);
    entered[t].irradiance += path.power / surface.area[t];
    entered[t].direction += path.power / surface.area[t] * path.direction;
  }
  for (EnteredLight& e : entered) {
    if (e.irradiance > 0.0) e.direction /= e.irradiance;
  }
  return entered;
}

DirectionalDipole::DirectionalDipole(const Material& material, const BoundaryConstants& constants)
    : D_(material.kappa),
      decay_(std::sqrt(material.mu / material.kappa)),
      depth_(2.131 * material.kappa / std::sqrt(1.0 - 3.0 * material.kappa * material.mu)),
      image_(2.0 * constants.A * depth_),
      of_fluence_(0.25 * (1.0 - constants.r_phi)),
      of_flux_(0.5 * (1.0 - constants.r_j)) {}

double DirectionalDipole::of_ray(double r2, const Eigen::Vector3d& x,
                                 const Eigen::Vector3d& direction,
                                 const Eigen::Vector3d& to_normal) const {
  const double r = std::sqrt(r2), q = decay_ * r, along = x.dot(direction);
  const double fluence = r2 / D_ + 3.0 * (1.0 + q) * along;
  const double flux =
      3.0 * D_ * (1.0 + q) * direction.dot(to_normal) -
      ((1.0 + q) + 3.0 * D_ * (3.0 * (1.0 + q) + q * q) / r2 * along) * x.dot(to_normal);
  return std::exp(-q) / (4.0 * std::numbers::pi * r2 * r) *
         (of_fluence_ * fluence - of_flux_ * flux);
}

double DirectionalDipole::value(const Eigen::Vector3d& from, const Eigen::Vector3d& normal,
                                const Eigen::Vector3d& direction, const Eigen::Vector3d& to,
                                const Eigen::Vector3d& to_normal) const {
  const Eigen::Vector3d x = to - from;
  const double r2 = x.squaredNorm();
  Eigen::Vector3d turned = normal;
  if (r2 > 0.0) {
    const Eigen::Vector3d across = normal.cross(x);
    const Eigen::Vector3d plane = x.cross(across);
    if (plane.squaredNorm() > 0.0) turned = plane.normalized();
  }
  // The real source is the ray: it is kept from the receiver by what [Frisvad et al.] 4.2 state.
  const double cosine = -to_normal.dot(direction), along = x.dot(direction);
  double near2 = D_ * D_;
  if (cosine > 0.0) {
    const double beta = -std::sqrt(std::max(0.0, r2 - along * along) / (r2 + depth_ * depth_));
    near2 = D_ * cosine * (D_ * cosine - 2.0 * depth_ * beta);
  }
  const Eigen::Vector3d image = x - image_ * turned;
  const Eigen::Vector3d mirrored = direction - 2.0 * direction.dot(turned) * turned;
  return of_ray(r2 + near2, x, direction, to_normal) -
         of_ray(image.squaredNorm(), image, mirrored, to_normal);
}

std::vector<double> directional_sum(const TriangleMesh& mesh, const Surface& surface,
                                    const DirectionalDipole& dipole,
                                    const std::vector<EnteredLight>& light) {
  std::vector<double> exitance(surface.size());
  for_rows(static_cast<int>(surface.size()), [&](int row) {
    const auto o = static_cast<std::size_t>(row);
    double sum = 0.0;
    for (std::size_t i = 0; i < surface.size(); ++i) {
      if (light[i].irradiance == 0.0) continue;
      Corners corners;
      for (std::size_t c = 0; c < 3; ++c)
        corners[c] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][c])];
      sum +=
          light[i].irradiance * integrated(dipole, corners, surface.normal[i], light[i].direction,
                                           surface.position[o], surface.normal[o], 0);
    }
    exitance[o] = sum;
  });
  return exitance;
}

}  // namespace kappamu::forward::dipole
