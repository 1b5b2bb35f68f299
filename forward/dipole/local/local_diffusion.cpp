#include "forward/dipole/local/local_diffusion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "core/processor_time.h"
#include "core/random.h"
#include "core/shown_text.h"
#include "forward/dipole/local/local_sum.h"
#include "forward/dipole/sum_check.h"

namespace kappamu::forward::dipole {

namespace {

/// Independent sets of points, whose spread is the standard error.
constexpr int sets = 4;
/// Samples of a triangle: those of the first attempt, and the most; and the most of a light over
/// all triangles, ten seconds of one core.
constexpr int first_samples = 32, most_of_triangle = 1 << 14, most_of_all = 4'000'000;
/// Of all samples, those of the light: where importance samples alone serve, more of them add the
/// noise of rare near ones (docs/dipole.md).
constexpr int light_share = 8;

/// Four sets know the noise they spread by to about this factor.
constexpr double noise_margin = 1.15;

using Values = std::vector<double>;

/// Whether what the eye sees is enough, and what it misses.
struct ImageSpace {
  std::vector<bool> seen;
  double missed = 0.0;  ///< relative 2-norm over the triangles seen, of the worst light
  bool holds = false;
};

ImageSpace image_space(const ObjectProblem& problem, const ObjectOptions& options,
                       const Profile& profile, const std::vector<Values>& irradiance) {
  ImageSpace image;
  if (!options.eye) return image;
  image.seen = seen_from(problem, *options.eye);
  Values area = problem.surface.area;
  for (std::size_t t = 0; t < area.size(); ++t) {
    if (!image.seen[t]) area[t] = 0.0;
  }
  if (*std::max_element(area.begin(), area.end()) == 0.0) return image;
  const SumCheck check(problem.mesh, problem.surface, area, options.seed);
  for (const Values& all : irradiance) {
    Values part = all;
    for (std::size_t t = 0; t < part.size(); ++t) {
      if (!image.seen[t]) part[t] = 0.0;
    }
    const Values exact = check.exact(profile, Placement::rotated, all);
    const Values of_part = check.exact(profile, Placement::rotated, part);
    image.missed = std::max(image.missed, check.difference(exact, of_part));
  }
  image.holds = image.missed <= 0.5 * options.tolerance;
  return image;
}

std::string percent(double share) {
  return shown_number(100.0 * share, "%.3g %%");
}

std::string where_summed(const ObjectOptions& options, const ImageSpace& image) {
  if (!options.eye) return "integrated over the surface";
  const std::string missed =
      "what entered where the camera does not see changes what it sees by " + percent(image.missed);
  return image.holds ? "integrated in image space: " + missed
                     : "integrated over the surface, not in image space: " + missed;
}

/// Mean and standard error of every triangle's exitance over the sets.
void estimate(const LocalSum& sum, const ObjectOptions& options, const ImageSpace& image,
              int samples, std::uint64_t light, Values& exitance, Values& error) {
  const int each = samples / sets, of_light = each / light_share;
  for_rows(static_cast<int>(exitance.size()), [&](int row) {
    const auto t = static_cast<std::size_t>(row);
    std::array<double, sets> values{};
    double mean = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < sets; ++k) {
      const SampleCounts counts{each - of_light, of_light, 0};
      const std::uint64_t key =
          key_of({options.seed, light, t, k, static_cast<std::uint64_t>(samples)});
      values[k] = image.holds && image.seen[t] ? sum.exitance_seen(t, counts, key, *options.eye)
                                               : sum.exitance(t, counts, key);
      mean += values[k] / sets;
    }
    for (const double value : values) squares += (value - mean) * (value - mean);
    exitance[t] = mean;
    error[t] = std::sqrt(squares / (sets * (sets - 1)));
  });
}

/// Relative 2-norm of the noise over the surface.
double noise_of(const Surface& surface, const Values& exitance, const Values& error) {
  double noise = 0.0, size = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    noise += surface.area[t] * error[t] * error[t];
    size += surface.area[t] * exitance[t] * exitance[t];
  }
  return size > 0.0 ? std::sqrt(noise / size) : 0.0;
}

}  // namespace

void sum_locally(const ObjectProblem& problem, const ObjectOptions& options, const Profile& profile,
                 const std::vector<Values>& irradiance, Progress& progress, ObjectResult& result) {
  const Stopwatch watch;
  const std::size_t triangles = problem.surface.size();
  const ImageSpace image = image_space(problem, options, profile, irradiance);
  const SumCheck check(problem.mesh, problem.surface, problem.surface.area, options.seed);
  result.setup_seconds = watch.seconds();
  result.converged = true;
  const int affordable = most_of_all / static_cast<int>(std::max<std::size_t>(triangles, 1));
  const int most_samples = std::clamp(affordable, first_samples, most_of_triangle);
  const double missed = image.holds ? image.missed : 0.0;
  int most = 0;
  double stated = 0.0;
  for (std::size_t l = 0; l < irradiance.size(); ++l) {
    const Values exact = check.exact(profile, Placement::rotated, irradiance[l]);
    const LocalSum sum(problem, profile, irradiance[l]);
    Values exitance(triangles), error(triangles);
    double worst = 0.0;
    int samples = first_samples;
    for (int attempt = 1;; ++attempt) {
      progress.update("local diffusion",
                      static_cast<double>(l) / static_cast<double>(irradiance.size()),
                      std::to_string(samples) + " samples a triangle");
      estimate(sum, options, image, samples, l, exitance, error);
      const double noise = noise_of(problem.surface, exitance, error);
      worst = std::max(check.error(exact, exitance), std::hypot(noise_margin * noise, missed));
      result.iterations = std::max(result.iterations, attempt);
      if (worst <= options.tolerance || samples >= most_samples) break;
      // The error falls at least with the root of the samples.
      const double wanted = std::pow(1.2 * worst / options.tolerance, 2.0);
      samples = std::min(most_samples, samples * static_cast<int>(std::ceil(std::min(
                                                     wanted, static_cast<double>(most_samples)))));
    }
    result.exitance.insert(result.exitance.end(), exitance.begin(), exitance.end());
    result.standard_error.insert(result.standard_error.end(), error.begin(), error.end());
    result.error_estimate.push_back(worst);
    result.converged = result.converged && worst <= options.tolerance;
    most = std::max(most, samples);
    stated = std::max(stated, worst);
  }
  result.elements = static_cast<std::size_t>(most) * triangles;
  result.message = where_summed(options, image) + "; " + std::to_string(most) +
                   " samples a triangle, error " + percent(stated) + " of the full integral" +
                   (result.converged ? "" : ": above the tolerance");
  if (!result.converged) result.warnings.push_back(result.message);
  result.seconds = watch.seconds() - result.setup_seconds;
}

}  // namespace kappamu::forward::dipole
