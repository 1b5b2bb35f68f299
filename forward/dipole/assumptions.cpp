#include "forward/dipole/assumptions.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/mesh/edges.h"
#include "core/parallel.h"
#include "core/shown_text.h"
#include "forward/polygrid/closest_point.h"
#include "forward/surface_rays.h"

namespace kappamu::forward::dipole {

namespace {

constexpr std::size_t most_rays = 1000;
/// [T] 3.6.1: 4.4 mean free paths of marble create 13 % of energy.
constexpr double thin_mean_free_paths = 5.0;
/// Of what crosses a slab of two diffusion lengths, e⁻² reaches the other side, which the
/// half-space has not.
constexpr double thin_diffusion_lengths = 2.0;
/// Shares of the surface up to which thin places are not reported.
constexpr double tolerable_share = 0.01;
/// 3κμ beyond which diffusion's own error in reflectance exceeds some per cent.
constexpr double most_absorbing = 0.1;
/// Of a source's depth: facets of a smooth surface may bring it this near.
constexpr double facets = 0.75;

}  // namespace

std::vector<std::string> assumption_warnings(const ObjectProblem& problem) {
  const Coefficients c = problem.medium.smallest();
  const double mean_free_path = 3.0 * c.kappa;
  const double diffusion_length = std::sqrt(c.kappa / std::max(c.mu, 1e-300));
  const Surface& surface = problem.surface;
  const std::size_t stride = (surface.size() + most_rays - 1) / most_rays;
  const SurfaceRays rays(problem);
  double area = 0.0, thin = 0.0, shallow = 0.0;
  for (std::size_t t = 0; t < surface.size(); t += stride) {
    const double thickness = rays.thickness(t);
    area += surface.area[t];
    if (thickness < thin_mean_free_paths * mean_free_path) thin += surface.area[t];
    if (thickness < thin_diffusion_lengths * diffusion_length) shallow += surface.area[t];
  }
  std::vector<std::string> warnings;
  const auto warn = [&](double part, double limit, const char* length, const char* effect) {
    if (part <= tolerable_share * area) return false;
    std::ostringstream text;
    text << std::lround(100.0 * part / area) << " % of the surface is thinner than " << limit << ' '
         << length << "; " << effect;
    warnings.push_back(text.str());
    return true;
  };
  if (!warn(thin, thin_mean_free_paths, "mean free paths",
            "the dipole creates light there, and the error estimate does not include it")) {
    warn(shallow, thin_diffusion_lengths, "diffusion lengths",
         "the dipole's half-space is deeper, and the error estimate does not include it");
  }
  if (const int pieces = oriented_alike(problem.mesh.triangles).components; pieces > 1) {
    warnings.push_back("the mesh has " + std::to_string(pieces) +
                       " separate surfaces; the dipole sends light across the voids and gaps "
                       "between them, and the error estimate does not include it");
  }
  if (mean_free_path * c.mu > most_absorbing) {
    std::ostringstream text;
    text << "a share of " << mean_free_path * c.mu
         << " of collisions absorbs; diffusion is wrong by several per cent beyond "
         << most_absorbing;
    warnings.push_back(text.str());
  }
  return warnings;
}

std::optional<std::string> aligned_source_warning(const ObjectProblem& problem) {
  const double depth = 3.0 * problem.medium.smallest().kappa;
  const Surface& surface = problem.surface;
  const ClosestPoint closest(problem.mesh);
  std::vector<double> distance(surface.size());
  for_rows(static_cast<int>(surface.size()), [&](int row) {
    const auto t = static_cast<std::size_t>(row);
    distance[t] = closest.from(surface.position[t] - depth * surface.normal[t], row).distance;
  });
  double area = 0.0, beside = 0.0, nearest = facets * depth;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    area += surface.area[t];
    if (distance[t] < facets * depth) beside += surface.area[t];
    nearest = std::min(nearest, distance[t]);
  }
  if (beside == 0.0) return std::nullopt;
  return formatted(
      "sources of %.0f %% of the surface lie beside another part of it, %.2g mean free paths at "
      "the nearest, where the exitance has no bound; use the model dipole-rotated",
      std::max(1.0, 100.0 * beside / area), nearest / depth);
}

}  // namespace kappamu::forward::dipole
