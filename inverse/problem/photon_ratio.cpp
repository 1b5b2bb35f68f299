#include "inverse/problem/photon_ratio.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/gaussian_sum.h"
#include "core/numbers/linear_algebra.h"
#include "core/numbers/median.h"
#include "core/optics.h"
#include "core/progress.h"
#include "forward/montecarlo/monte_carlo_model.h"
#include "inverse/defaults.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::photon_ratio;

constexpr std::uint64_t slope_key = 0xD1B54A32D192ED03U;
/// A key of our own: data simulated with the fit's seed must not share its noise.
constexpr std::uint64_t own_key = 0x9E3779B97F4A7C15U;

/// The fit's coefficients within the range of transport, their logarithms lowered by so much.
Medium walkable(const PhotonProblem& problem, double lower_kappa, double lower_mu) {
  Medium medium{Volume<double>(problem.setup.shape, problem.kappa),
                Volume<double>(problem.setup.shape, problem.mu)};
  for (double& kappa : medium.kappa.values()) kappa *= std::exp(-lower_kappa);
  for (double& mu : medium.mu.values()) mu *= std::exp(-lower_mu);
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

std::uint64_t enough_photons(const PhotonProblem& problem, const PhotonOptions& options) {
  const std::vector<double> light = whole_light(problem);
  const std::size_t cells = problem.seen_shape.cells();
  std::vector<double> needed;  // a pixel's variance is at most light × exitance over photons
  for (std::size_t i = 0; i < problem.diffusion.size(); ++i) {
    if (!std::isfinite(problem.variance[i]) || light[i / cells] == 0.0) continue;
    const double tolerated = std::max(std::pow(options.noise, 2) * problem.variance[i],
                                      std::pow(options.pilot_noise * problem.diffusion[i], 2));
    needed.push_back(light[i / cells] * problem.diffusion[i] / tolerated);
  }
  if (needed.empty()) return fewest_photons;
  const double wanted =
      std::clamp(upper_median(std::move(needed)), static_cast<double>(fewest_photons),
                 static_cast<double>(most_photons) / std::pow(options.noise, 2));
  // Steps of two: chance must not change with every small change of χ².
  return static_cast<std::uint64_t>(std::exp2(std::ceil(std::log2(wanted))));
}

/// The maps of one pattern.
struct Pattern {
  std::vector<double> transport, diffusion;  ///< M [v][u]
  std::vector<double> datum;                 ///< variance tolerated
  double noise = 0.0;                        ///< variance of transport over exitance
  double tolerated = 1.0;                    ///< variance as smoothed, over the datum's
  bool smooth = true;
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
                                   ? pattern.tolerated * pattern.datum[k]
                                   : unseen_noise * unseen_noise * here * here;
      if (pattern.smooth && variance > tolerated && width < widest) continue;
      done[k] = true;
      --left;
      found.ratio[first + k] = diffusion[k] > 0.0 ? transport[k] / diffusion[k] : 1.0;
      found.variance[first + k] = variance;
      found.pixel_variance[first + k] = std::max(variance, pattern.noise * here);
    }
  }
}

/// Slopes of the ratio over all pixels by regression on what diffusion knows of them: how bright
/// they are, ℓ = log M/M_max, and by how much κ and μ change that, a and b. 1, ℓ, ℓ², a, b, a², ab,
/// b² follow a patch's blur and the block's edges, and leave nearly nothing of the photons' noise,
/// which single pixels' differences are full of.
class Slopes {
 public:
  void add(std::size_t pixel, const std::array<double, 3>& known,
           const std::array<double, 2>& slope, double variance) {
    const auto& [l, a, b] = known;
    Eigen::Matrix<double, terms, 1> row;
    row << 1.0, l, l * l, a, b, a * a, a * b, b * b;
    const Eigen::RowVector2d value(slope[0], slope[1]);
    if (!row.allFinite()) return;
    pixels_.emplace_back(pixel, row);
    if (!value.allFinite() || !std::isfinite(variance)) return;
    const double weight = 1.0 / (variance + slope_misfit * slope_misfit);
    normal_ += weight * row * row.transpose();
    right_ += weight * row * value;
  }

  std::array<std::vector<double>, 2> evaluate(std::size_t count) const {
    constexpr double ridge = 1e-6;  // where terms are alike
    Eigen::Matrix<double, terms, terms> normal = normal_;
    normal.diagonal() += ridge * normal.diagonal();
    normal.diagonal().array() += ridge;
    const Eigen::Matrix<double, terms, 2> coefficients = solve_symmetric(normal, right_);
    std::array<std::vector<double>, 2> slope{std::vector<double>(count, 0.0),
                                             std::vector<double>(count, 0.0)};
    for (const auto& [pixel, row] : pixels_) {
      const Eigen::RowVector2d value = row.transpose() * coefficients;
      for (std::size_t k = 0; k < 2; ++k) {
        slope[k][pixel] = std::clamp(value[static_cast<Eigen::Index>(k)], -steepest, steepest);
      }
    }
    return slope;
  }

 private:
  static constexpr int terms = 8;
  static constexpr double steepest = 5.0;
  Eigen::Matrix<double, terms, terms> normal_ = Eigen::Matrix<double, terms, terms>::Zero();
  Eigen::Matrix<double, terms, 2> right_ = Eigen::Matrix<double, terms, 2>::Zero();
  std::vector<std::pair<std::size_t, Eigen::Matrix<double, terms, 1>>> pixels_;
};

double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double x : values) total += x;
  return total;
}

}  // namespace

PhotonRatio photon_ratio(const PhotonProblem& problem, const PhotonOptions& options) {
  const FaceShape grid_face = face_shape(problem.setup.shape, problem.seen_face);
  const FaceShape face = problem.seen_shape;
  const bool slope = !problem.diffusion_below[0].empty();
  forward::ForwardOptions how;
  how.device = options.device;
  how.seed = options.seed ^ own_key;
  how.anisotropy = options.anisotropy;
  how.photons = enough_photons(problem, options);
  how.cameras = problem.cameras;
  const auto face_of = [&](std::size_t m) {
    return problem.seen_faces.empty() ? problem.seen_face : problem.seen_faces[m];
  };
  // Of all faces' maps, those of the face that each pattern is seen on.
  const auto seen = [&](const std::array<std::vector<double>, 6>& maps) {
    std::vector<double> own;
    for (std::size_t m = 0; m < static_cast<std::size_t>(problem.patterns); ++m) {
      const auto at = std::find(all_faces.begin(), all_faces.end(), face_of(m));
      const auto first = maps[static_cast<std::size_t>(at - all_faces.begin())].begin() +
                         static_cast<std::ptrdiff_t>(m * grid_face.cells());
      own.insert(own.end(), first, first + static_cast<std::ptrdiff_t>(grid_face.cells()));
    }
    return own;
  };
  const std::size_t count = problem.diffusion.size();
  PhotonRatio found{std::vector<double>(count, 1.0), std::vector<double>(count, 0.0),
                    std::vector<double>(count, 0.0), 0};
  struct Walk {
    std::vector<double> exitance, variance;  // [M][v][u]
  };
  const auto trace = [&](double lower_kappa, double lower_mu) {
    const forward::ForwardProblem walk{problem.setup, walkable(problem, lower_kappa, lower_mu),
                                       problem.patterns, problem.irradiance};
    Progress silent;
    found.photons += how.photons;
    forward::ForwardResult traced = forward::make_monte_carlo_model()->solve(walk, how, silent);
    std::vector<double> variance = seen(traced.standard_error);
    for (double& e : variance) e *= e / (problem.factor * problem.factor);
    const auto to_pixels = [&](const std::vector<double>& values) {
      return restrict_face(values, grid_face, face, problem.factor, problem.patterns);
    };
    return Walk{to_pixels(seen(traced.exitance)), to_pixels(variance)};
  };
  const Walk traced = trace(0.0, 0.0);
  std::vector<Walk> walks;  // for slopes: their noise must be none that the misfit, too, contains
  if (slope) {
    how.seed ^= slope_key;
    how.photons /= photons_over_slope;
    walks = {trace(0.0, 0.0), trace(slope_step, 0.0), trace(0.0, slope_step)};
  }

  std::array<Slopes, 2> slopes;  // of the pictures on seen_face, and of those on its opposite
  const std::vector<double> light = whole_light(problem);
  for (std::size_t m = 0; m < light.size(); ++m) {
    if (light[m] == 0.0) continue;
    const std::size_t first = m * face.cells();
    const auto map = [&](const std::vector<double>& maps) {
      const auto begin = maps.begin() + static_cast<std::ptrdiff_t>(first);
      return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(face.cells()));
    };
    Pattern pattern{map(traced.exitance),
                    map(problem.diffusion),
                    map(problem.variance),
                    0.0,
                    tolerated_noise * std::pow(options.noise, 2),
                    !slope && options.pilot_noise == 0.0};
    for (double& m_diffusion : pattern.diffusion) m_diffusion = std::max(m_diffusion, 0.0);
    const double whole = sum(pattern.diffusion);
    if (whole == 0.0) continue;
    // Photons of a pattern leave with much the same weight: their variance is as their mean.
    pattern.noise = sum(map(traced.variance)) / whole;
    smooth(pattern, face, first, found);
    if (!slope) continue;
    const double noise = sum(map(walks[0].variance)) / whole;
    const double brightest = *std::max_element(pattern.diffusion.begin(), pattern.diffusion.end());
    for (std::size_t k = 0; k < face.cells(); ++k) {
      const std::size_t i = first + k;
      const double exitance = pattern.diffusion[k];
      std::array<double, 2> of_diffusion{}, of_ratio{};
      for (std::size_t unknown = 0; unknown < 2; ++unknown) {
        const auto change = [&](double here, double below) {
          return std::log(here / below) / slope_step;
        };
        of_diffusion[unknown] = change(exitance, problem.diffusion_below[unknown][i]);
        of_ratio[unknown] =
            change(walks[0].exitance[i], walks[unknown + 1].exitance[i]) - of_diffusion[unknown];
      }
      slopes[face_of(m) == problem.seen_face ? 0 : 1].add(
          i, {std::log(exitance / brightest), of_diffusion[0], of_diffusion[1]}, of_ratio,
          noise / (slope_step * slope_step * exitance));
    }
  }
  if (!slope) return found;
  found.slope = slopes[0].evaluate(count);
  const auto opposite_slope = slopes[1].evaluate(count);
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t i = 0; i < count; ++i) found.slope[k][i] += opposite_slope[k][i];
  }
  return found;
}

}  // namespace kappamu::inverse
