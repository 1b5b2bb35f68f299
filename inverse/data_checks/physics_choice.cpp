#include "inverse/data_checks/physics_choice.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/shown_text.h"
#include "inverse/defaults.h"

namespace kappamu::inverse {

namespace {

using namespace defaults::physics_choice;

/// Sum of the data of a pattern.
double brightness(const Problem& problem, int pattern) {
  const std::size_t cells = problem.seen_shape().cells();
  double sum = 0.0;
  for (std::size_t i = static_cast<std::size_t>(pattern) * cells, end = i + cells; i < end; ++i) {
    if (problem.weight[i] > 0.0) sum += problem.data[i];
  }
  return sum;
}

/// The brightest of each quarter of the sequence.
Problem some_patterns(const Problem& problem) {
  Problem some = problem;
  some.patterns = std::min(problem.patterns, pilot_patterns);
  some.precision.reset();  // of all patterns
  std::vector<int> chosen;
  for (int k = 0; k < some.patterns; ++k) {
    int best = k * problem.patterns / some.patterns;
    for (int m = best; m < (k + 1) * problem.patterns / some.patterns; ++m) {
      if (brightness(problem, m) > brightness(problem, best)) best = m;
    }
    chosen.push_back(best);
  }
  const auto take = [&](const std::vector<double>& from, std::size_t cells) {
    std::vector<double> taken;
    for (const int m : chosen) {
      const auto begin = from.begin() + static_cast<std::ptrdiff_t>(cells) * m;
      taken.insert(taken.end(), begin, begin + static_cast<std::ptrdiff_t>(cells));
    }
    return taken;
  };
  if (!problem.seen_faces.empty()) {
    std::vector<Face> faces;
    for (const int m : chosen) faces.push_back(problem.seen_faces[static_cast<std::size_t>(m)]);
    set_seen_faces(std::move(faces), some.seen_face, some.seen_faces);
  }
  some.lateral.clear();
  for (const int m : chosen) {
    if (!problem.lateral.empty()) {
      some.lateral.push_back(problem.lateral[static_cast<std::size_t>(m)]);
    }
  }
  some.irradiance = take(problem.irradiance, problem.lit_shape().cells());
  some.data = take(problem.data, problem.seen_shape().cells());
  some.weight = take(problem.weight, problem.seen_shape().cells());
  return some;
}

}  // namespace

PhysicsChoice choose_physics(const Problem& problem, const HomogeneousFit& start,
                             const Backend& backend, PhotonOptions photons) {
  Objective objective(some_patterns(problem), backend);
  Refinement refinement = refine(objective.problem());
  const std::size_t cells = problem.setup.shape.cells();
  const auto refitted = [&](HomogeneousFit at) {
    objective.refresh_correction(refinement, {std::vector<double>(cells, std::log(at.kappa)),
                                              std::vector<double>(cells, std::log(at.mu))});
    at.jacobian.resize(0, 0);  // of another grid
    return refit_homogeneous(objective, at);
  };
  const HomogeneousFit diffusion = refitted(start);
  photons.pilot_noise = pilot_noise;
  refinement.photons = photons;
  const HomogeneousFit transport = refitted(diffusion);
  const Eigen::Array2d tolerated = (negligible_deviations * start.deviation.array())
                                       .max(Eigen::Array2d(tolerated_kappa, tolerated_mu));
  const bool same = ((transport.logs() - diffusion.logs()).array().abs() < tolerated).all();
  return {same ? Physics::diffusion : Physics::transport,
          formatted("The homogeneous block that suits some patterns best has κ %.3g mm and μ "
                    "%.3g/mm by diffusion, %.3g and %.3g by transport: the fit is by %s.",
                    diffusion.kappa, diffusion.mu, transport.kappa, transport.mu,
                    same ? "diffusion" : "transport"),
          objective.solves()};
}

}  // namespace kappamu::inverse
