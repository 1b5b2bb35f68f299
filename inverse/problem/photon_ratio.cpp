#include "inverse/problem/photon_ratio.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/median.h"
#include "core/optics.h"
#include "core/progress.h"
#include "forward/montecarlo/monte_carlo_model.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

namespace {

constexpr std::uint64_t fewest_photons = 1 << 14;  // of each pattern
constexpr std::uint64_t most_photons = 1 << 22;
/// Variance of a smoothed pixel over its datum's: smoothing goes no further.
constexpr double tolerated_noise = 0.25;
/// Relative deviation tolerated where no datum says what is.
constexpr double unseen_noise = 0.1;
/// A key of our own: data simulated with the fit's seed must not share its noise.
constexpr std::uint64_t own_key = 0x9E3779B97F4A7C15U;
/// μ/σt' of a voxel that leaves no scattering, and κ below which a voxel is a mirror to light and
/// slows all photons, as shares of the median κ and of the voxel's edge (200 mean free paths): none
/// is a material, all occur on a fit's way.
constexpr double most_absorption = 0.999;
constexpr double least_kappa_of_median = 0.02;
constexpr double least_kappa_of_voxel = 1.0 / 600.0;

/// What transport can read of a fit's coefficients.
Medium walkable(const PhotonProblem& problem) {
  Medium medium{Volume<double>(problem.setup.shape, problem.kappa),
                Volume<double>(problem.setup.shape, problem.mu)};
  const double least = std::max(least_kappa_of_median * upper_median(problem.kappa),
                                least_kappa_of_voxel * problem.setup.shape.voxel_mm);
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    medium.kappa[i] = std::max(medium.kappa[i], least);
    medium.mu[i] = std::min(medium.mu[i], most_absorption / (3.0 * medium.kappa[i]));
  }
  return medium;
}

/// Power that enters under each pattern, per pixel area: the exitance of one pixel that all of it
/// left by.
std::vector<double> whole_light(const PhotonProblem& problem) {
  const std::size_t lit = face_shape(problem.setup.shape, problem.setup.lit_face).cells();
  const double transmittance = boundary_constants(problem.setup.eta).normal_transmittance;
  const double pixel = problem.factor * problem.factor;
  std::vector<double> light(static_cast<std::size_t>(problem.patterns), 0.0);
  for (std::size_t i = 0; i < problem.irradiance.size(); ++i) {
    light[i / lit] += transmittance * problem.irradiance[i] / pixel;
  }
  return light;
}

std::uint64_t enough_photons(const PhotonProblem& problem) {
  const std::vector<double> light = whole_light(problem);
  const std::size_t cells = problem.seen_shape.cells();
  std::vector<double> needed;  // a pixel's variance is at most light × exitance over photons
  for (std::size_t i = 0; i < problem.diffusion.size(); ++i) {
    if (!std::isfinite(problem.variance[i]) || light[i / cells] == 0.0) continue;
    needed.push_back(light[i / cells] * problem.diffusion[i] / problem.variance[i]);
  }
  if (needed.empty()) return fewest_photons;
  const double wanted =
      std::clamp(upper_median(std::move(needed)), static_cast<double>(fewest_photons),
                 static_cast<double>(most_photons));
  // Steps of two: chance must not change with every small change of χ².
  return static_cast<std::uint64_t>(std::exp2(std::ceil(std::log2(wanted))));
}

/// Σ over pixels of a Gaussian of `width` pixels to `power` (its middle 1) times `map` [v][u].
std::vector<double> gaussian_sum(const std::vector<double>& map, FaceShape face, double width,
                                 int power) {
  if (width == 0.0) return map;
  const int reach = static_cast<int>(std::ceil(3.0 * width));
  std::vector<double> kernel;
  for (int d = 0; d <= reach; ++d) kernel.push_back(std::exp(-0.5 * power * d * d / width / width));
  const auto along = [&](const std::vector<double>& from, int count, int stride, int lines,
                         int line_stride) {
    std::vector<double> to(from.size(), 0.0);
    for (int line = 0; line < lines; ++line) {
      for (int i = 0; i < count; ++i) {
        double sum = 0.0;
        for (int j = std::max(0, i - reach); j <= std::min(count - 1, i + reach); ++j) {
          sum += kernel[static_cast<std::size_t>(std::abs(i - j))] *
                 from[static_cast<std::size_t>(line * line_stride + j * stride)];
        }
        to[static_cast<std::size_t>(line * line_stride + i * stride)] = sum;
      }
    }
    return to;
  };
  return along(along(map, face.nu, 1, face.nv, face.nu), face.nv, face.nu, face.nu, 1);
}

/// The maps of one pattern.
struct Pattern {
  std::vector<double> transport, diffusion;  ///< M [v][u]
  std::vector<double> datum;                 ///< variance tolerated
  double noise = 0.0;                        ///< variance of transport over exitance
};

/// Each pixel's ratio by the narrowest mean that is quiet enough, into `found` from `first` on.
void smooth(const Pattern& pattern, FaceShape face, std::size_t first, PhotonRatio& found) {
  const std::size_t cells = face.cells();
  std::vector<bool> done(cells, false);
  std::size_t left = cells;
  const double widest = 2.0 * std::max(face.nu, face.nv);
  for (double width = 0.0; left > 0; width = width == 0.0 ? 0.5 : width * std::sqrt(2.0)) {
    const std::vector<double> transport = gaussian_sum(pattern.transport, face, width, 1);
    const std::vector<double> diffusion = gaussian_sum(pattern.diffusion, face, width, 1);
    const std::vector<double> squares = gaussian_sum(pattern.diffusion, face, width, 2);
    for (std::size_t k = 0; k < cells; ++k) {
      if (done[k]) continue;
      const double here = pattern.diffusion[k];
      const double per_sum = diffusion[k] > 0.0 ? here / diffusion[k] : 0.0;
      const double variance = pattern.noise * squares[k] * per_sum * per_sum;
      const double tolerated = std::isfinite(pattern.datum[k])
                                   ? tolerated_noise * pattern.datum[k]
                                   : unseen_noise * unseen_noise * here * here;
      if (variance > tolerated && width < widest) continue;
      done[k] = true;
      --left;
      found.ratio[first + k] = diffusion[k] > 0.0 ? transport[k] / diffusion[k] : 1.0;
      found.variance[first + k] = variance;
      found.pixel_variance[first + k] = std::max(variance, pattern.noise * here);
    }
  }
}

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double x : values) total += x;
  return total;
}

}  // namespace

PhotonRatio photon_ratio(const PhotonProblem& problem, const PhotonOptions& options) {
  const FaceShape grid_face = face_shape(problem.setup.shape, problem.seen_face);
  const FaceShape face = problem.seen_shape;
  forward::ForwardProblem walk{problem.setup, walkable(problem), problem.patterns,
                               problem.irradiance};
  forward::ForwardOptions how;
  how.device = options.device;
  how.seed = options.seed ^ own_key;
  how.photons = enough_photons(problem);
  Progress silent;
  const forward::ForwardResult traced = forward::make_monte_carlo_model()->solve(walk, how, silent);
  const auto at = static_cast<std::size_t>(
      std::find(all_faces.begin(), all_faces.end(), problem.seen_face) - all_faces.begin());
  std::vector<double> variance = traced.standard_error[at];
  for (double& e : variance) e *= e / (problem.factor * problem.factor);
  const auto to_pixels = [&](const std::vector<double>& values) {
    return restrict_face(values, grid_face, face, problem.factor, problem.patterns);
  };
  const std::vector<double> transport = to_pixels(traced.exitance[at]);
  variance = to_pixels(variance);

  const std::size_t count = problem.diffusion.size();
  PhotonRatio found{std::vector<double>(count, 1.0), std::vector<double>(count, 0.0),
                    std::vector<double>(count, 0.0), how.photons};
  const std::vector<double> light = whole_light(problem);
  for (std::size_t m = 0; m < light.size(); ++m) {
    if (light[m] == 0.0) continue;
    const std::size_t first = m * face.cells();
    const auto map = [&](const std::vector<double>& maps) {
      const auto begin = maps.begin() + static_cast<std::ptrdiff_t>(first);
      return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(face.cells()));
    };
    Pattern pattern{map(transport), map(problem.diffusion), map(problem.variance), 0.0};
    for (double& m_diffusion : pattern.diffusion) m_diffusion = std::max(m_diffusion, 0.0);
    const double whole = sum(pattern.diffusion);
    if (whole == 0.0) continue;
    // Photons of a pattern leave with much the same weight: their variance is as their mean.
    pattern.noise = sum(map(variance)) / whole;
    smooth(pattern, face, first, found);
  }
  return found;
}

}  // namespace kappamu::inverse
