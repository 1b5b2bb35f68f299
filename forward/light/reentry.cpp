#include "forward/light/reentry.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/surface_norm.h"
#include "core/optics.h"
#include "core/parallel.h"
#include "core/random.h"
#include "forward/light/beam_path.h"
#include "forward/light_entry.h"
#include "forward/surface_rays.h"

namespace kappamu::forward {

namespace {

/// Rays that give the power within a percent of what leaves, and each triangle's irradiance within
/// some percent of its exitance.
constexpr std::size_t rays_for_share = 20'000;
constexpr std::size_t rays_to_follow = 64;
/// Of the tolerance, the light that is left when it is followed no more.
constexpr double echo_left = 0.1;
constexpr int most_rounds = 20;

std::size_t rays_per_triangle(std::size_t triangles, bool follow) {
  return follow ? rays_to_follow : std::max<std::size_t>(1, rays_for_share / triangles);
}

/// Exitance of one light of a result.
std::vector<double> exitance_of(const ObjectResult& result, std::size_t light,
                                std::size_t samples) {
  const auto first = result.exitance.begin() + static_cast<std::ptrdiff_t>(light * samples);
  return {first, first + static_cast<std::ptrdiff_t>(samples)};
}

double power(const Surface& surface, const std::vector<double>& flux) {
  double sum = 0.0;
  for (std::size_t t = 0; t < flux.size(); ++t) sum += surface.area[t] * flux[t];
  return sum;
}

/// Adds a round's answer to all before it.
void add(const ObjectResult& round, const Surface& surface, ObjectResult& total) {
  const std::size_t samples = surface.size();
  for (std::size_t l = 0; l < total.balance.size(); ++l) {
    const std::vector<double> more = exitance_of(round, l, samples);
    std::vector<double> all = exitance_of(total, l, samples);
    const double error = total.error_estimate[l] * surface_norm(surface, all) +
                         round.error_estimate[l] * surface_norm(surface, more);
    for (std::size_t t = 0; t < samples; ++t) {
      total.exitance[l * samples + t] += more[t];
      all[t] += more[t];
    }
    const double size = surface_norm(surface, all);
    total.error_estimate[l] = size > 0.0 ? error / size : 0.0;
    total.balance[l].entering += round.balance[l].entering;
    total.balance[l].unscattered += round.balance[l].unscattered;
    total.balance[l].exiting += round.balance[l].exiting;
    total.balance[l].absorbed += round.balance[l].absorbed;
  }
  total.iterations = std::max(total.iterations, round.iterations);
  total.elements = std::max(total.elements, round.elements);
  total.setup_seconds += round.setup_seconds;
  total.seconds += round.seconds;
  total.converged = total.converged && round.converged;
}

}  // namespace

SeenTriangles::SeenTriangles(const ObjectProblem& problem, std::size_t rays_per_triangle)
    : rays_(rays_per_triangle), seen_(problem.surface.size() * rays_per_triangle, -1) {
  const Surface& surface = problem.surface;
  const SurfaceRays rays(problem);
  for_ranges(surface.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Eigen::Vector3d normal = surface.normal[t];
      const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
      for (std::size_t k = 0; k < rays_; ++k) {
        // By the cosine (Malley's method).
        const auto [a, b] = sobol_point(static_cast<std::uint32_t>(k), t);
        const double radius = std::sqrt(a), angle = 2.0 * M_PI * b;
        const Eigen::Vector3d direction = radius * std::cos(angle) * u +
                                          radius * std::sin(angle) * v +
                                          std::sqrt(1.0 - a) * normal;
        if (const auto hit = rays.first_hit(t, direction)) seen_[t * rays_ + k] = hit->triangle;
      }
    }
  });
}

std::vector<double> SeenTriangles::irradiance(const std::vector<double>& exitance) const {
  std::vector<double> result(exitance.size(), 0.0);
  for (std::size_t t = 0; t < result.size(); ++t) {
    for (std::size_t k = t * rays_; k < (t + 1) * rays_; ++k) {
      if (seen_[k] >= 0) {
        result[t] += exitance[static_cast<std::size_t>(seen_[k])] / static_cast<double>(rays_);
      }
    }
  }
  return result;
}

std::vector<ObjectResult> with_reentry(std::span<const ObjectProblem> problems,
                                       const ObjectOptions& options, const SolveOnce& once) {
  std::vector<ObjectResult> total = once(problems, options);
  const Surface& surface = problems[0].surface;
  const std::size_t samples = surface.size();
  const SeenTriangles seen(problems[0], rays_per_triangle(samples, options.follow_reentry));
  const double transmitted = diffuse_transmittance(boundary_constants(problems[0].eta));
  const MeshWalls walls(problems[0]);
  std::vector<ObjectResult> last = total;
  std::vector<std::vector<ObjectLight>> again(problems.size());
  for (std::size_t c = 0; c < problems.size(); ++c) again[c].resize(problems[c].lights.size());
  for (int round = 0;; ++round) {
    double largest = 0.0;  // share of what leaves
    for (std::size_t c = 0; c < problems.size(); ++c) {
      for (std::size_t l = 0; l < again[c].size(); ++l) {
        std::vector<double> leaving = exitance_of(last[c], l, samples);
        // What the surface reflected of the round before leaves with it.
        for (std::size_t t = 0; t < again[c][l].diffuse.size(); ++t) {
          leaving[t] += (1.0 - transmitted) * again[c][l].diffuse[t];
        }
        again[c][l].diffuse = seen.irradiance(leaving);
        double arriving = power(surface, again[c][l].diffuse);
        again[c][l].beams.clear();
        for (const Beam& beam : last[c].leaving[l]) {
          arriving += meet_again(walls, beam, again[c][l].beams);
        }
        last[c].leaving[l].clear();
        total[c].leaving[l].clear();
        ObjectBalance& balance = total[c].balance[l];
        balance.reentering += arriving;
        const double left = balance.exiting + balance.unscattered;
        if (left > 0.0) largest = std::max(largest, arriving / left);
      }
    }
    if (!options.follow_reentry || largest <= echo_left * options.tolerance ||
        round == most_rounds) {
      return total;
    }
    std::vector<ObjectProblem> echoes;
    for (std::size_t c = 0; c < problems.size(); ++c) {
      const ObjectProblem& p = problems[c];
      echoes.push_back({p.mesh, p.surface, p.rays, p.medium, p.eta, again[c]});
    }
    ObjectOptions coarser = options;
    coarser.tolerance = std::min(0.5, options.tolerance / largest);
    last = once(echoes, coarser);
    for (std::size_t c = 0; c < problems.size(); ++c) add(last[c], surface, total[c]);
  }
}

}  // namespace kappamu::forward
