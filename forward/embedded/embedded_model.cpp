#include "forward/embedded/embedded_model.h"

#include <algorithm>
#include <numeric>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/bodies.h"
#include "forward/embedded/body_solve.h"
#include "forward/light/reentry.h"
#include "forward/light_entry.h"
#include "forward/object_verdict.h"

namespace kappamu::forward {

namespace {

using namespace embedded;

/// Of the surface.
constexpr double worth_a_warning = 1e-3;

/// Adds a body's answer to a channel's. `error_estimate` collects squares until all are in.
void add(const Body& body, const BodyAnswer& part, std::size_t channel, std::size_t samples,
         ObjectResult& result) {
  const Answer& answer = part.channel[channel];
  for (std::size_t l = 0; l < answer.exitance.size(); ++l) {
    for (std::size_t t = 0; t < body.triangle.size(); ++t) {
      result.exitance[l * samples + static_cast<std::size_t>(body.triangle[t])] =
          answer.exitance[l][t];
    }
    result.error_estimate[l] += part.error[channel][l] * part.error[channel][l];
    const ObjectBalance& from = answer.balance[l];
    ObjectBalance& to = result.balance[l];
    to.entering += from.entering;
    to.unscattered += from.unscattered;
    to.exiting += from.exiting;
    to.absorbed += from.absorbed;
    for (Beam beam : answer.leaving[l]) {
      beam.triangle = body.triangle[static_cast<std::size_t>(beam.triangle)];
      result.leaving[l].push_back(beam);
    }
  }
  result.elements += part.cubes;
  result.iterations = std::max(result.iterations, part.iterations);
  result.setup_seconds += part.setup_seconds;
  result.seconds += part.seconds;
}

bool begins_inside(const Surface& surface, const std::vector<ObjectLight>& lights) {
  return std::any_of(lights.begin(), lights.end(), [&](const ObjectLight& light) {
    return std::any_of(light.beams.begin(), light.beams.end(), [&](const Beam& beam) {
      return beam.direction.dot(surface.normal[static_cast<std::size_t>(beam.triangle)]) > 0.0;
    });
  });
}

BodyAnswer solve_part(const Body& body, std::span<const ObjectProblem> problems,
                      const ObjectOptions& options, Progress& progress) {
  std::vector<int> local(problems[0].surface.size(), -1);
  for (std::size_t t = 0; t < body.triangle.size(); ++t) {
    local[static_cast<std::size_t>(body.triangle[t])] = static_cast<int>(t);
  }
  const Surface surface = surface_of(body.mesh);
  std::vector<std::vector<ObjectLight>> own;
  bool inside = false;
  for (const ObjectProblem& problem : problems) {
    own.push_back(lights_of(body, local, problem.lights));
    inside = inside || begins_inside(surface, own.back());
  }
  if (inside) {
    for (auto& lights : own) lights.push_back({{}, std::vector<double>(surface.size(), 1.0)});
  }
  const BodyRays rays(problems[0].rays, std::move(local));
  std::vector<ObjectProblem> parts;
  for (std::size_t c = 0; c < problems.size(); ++c) {
    parts.push_back({body.mesh, surface, rays, problems[c].medium, problems[c].eta, own[c]});
  }
  BodyAnswer answer = solve_body(parts, options, inside, progress);
  if (inside) {
    for (Answer& channel : answer.channel) channel.exitance.pop_back();
  }
  return answer;
}

/// `bridged`: share of the surface.
void finish(const ObjectProblem& problem, const Ended& ended, double bridged,
            ObjectResult& result) {
  conclude(problem.surface, ended, "cubes", result);
  if (bridged < worth_a_warning) return;
  result.warnings.push_back(
      formatted("%.2g %% of the surface lies in slits narrower than its cubes; light crosses there "
                "that should not, and the error estimate may not include it",
                100.0 * bridged));
}

/// Light that leaves is not followed.
std::vector<ObjectResult> solve_once(std::span<const ObjectProblem> problems,
                                     const ObjectOptions& options, Progress& progress) {
  std::vector<ObjectResult> results(problems.size());
  const std::size_t samples = problems[0].surface.size();
  for (std::size_t c = 0; c < problems.size(); ++c) {
    const std::size_t lights = problems[c].lights.size();
    results[c].exitance.assign(lights * samples, 0.0);
    results[c].error_estimate.assign(lights, 0.0);
    results[c].balance.resize(lights);
    results[c].leaving.resize(lights);
  }
  Ended ended;
  double bridged_area = 0.0;
  for (const Body& body : bodies(problems[0].mesh, problems[0].rays)) {
    const BodyAnswer answer = solve_part(body, problems, options, progress);
    for (std::size_t c = 0; c < problems.size(); ++c) add(body, answer, c, samples, results[c]);
    ended.within_tolerance = ended.within_tolerance && answer.within_tolerance;
    ended.solved = ended.solved && answer.solved;
    bridged_area += answer.bridged_area;
  }
  const std::vector<double>& area = problems[0].surface.area;
  const double bridged = bridged_area / std::accumulate(area.begin(), area.end(), 0.0);
  for (std::size_t c = 0; c < problems.size(); ++c) {
    finish(problems[c], ended, bridged, results[c]);
  }
  return results;
}

}  // namespace

std::vector<ObjectResult> EmbeddedModel::solve_channels(std::span<const ObjectProblem> problems,
                                                        const ObjectOptions& options,
                                                        Progress& progress) {
  for (const ObjectProblem& problem : problems) check_problem(problem, options);
  if (problems.empty()) return {};
  return with_reentry(problems, options,
                      [&](std::span<const ObjectProblem> asked, const ObjectOptions& how) {
                        return solve_once(asked, how, progress);
                      });
}

ModelDescription embedded_model() {
  return {.name = "embedded",
          .text = "Diffusion on cubes cut by the surface, refined until two resolutions agree.",
          .limits =
              "Diffusion errs in parts thinner than a few mean free paths, at sharp edges and "
              "where absorption is strong.",
          .can = {.heterogeneous = true,
                  .voids = true,
                  .several_bodies = true,
                  .inner_light = true,
                  .live = true,
                  .reentry = true},
          .make = [] { return std::make_unique<EmbeddedModel>(); },
          .measured = &measured("embedded"),
          .errs_by = &measured("embedded").error};
}

}  // namespace kappamu::forward
