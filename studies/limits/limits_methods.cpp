// The methods of the papers at their edges: [W] (8)'s stencil and relaxation.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "forward/forward_model.h"
#include "studies/baseline/baseline_model.h"
#include "studies/limits/limits.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using forward::ForwardOptions;
using forward::ForwardProblem;
using forward::ForwardResult;

ForwardProblem problem_of(const GridShape& shape, const MediumSpec& spec) {
  ForwardProblem problem;
  problem.setup = {.shape = shape};
  problem.medium = make_medium(shape, spec);
  problem.irradiance = patch_light(shape, problem.setup.lit_face, 1);
  return problem;
}

ForwardResult answer(const char* method, const ForwardProblem& problem,
                     const forward::SolveOptions& solve, const Request& request) {
  ForwardOptions asked;
  asked.device = request.device;
  asked.solve = solve;
  Progress silent;
  return baseline::make_model(method)->solve(problem, asked, silent);
}

/// ‖M − M*‖/‖M*‖ over all faces.
double exitance_error(const ForwardResult& result, const ForwardResult& truth) {
  double distance = 0.0, size = 0.0;
  for (std::size_t f = 0; f < all_faces.size(); ++f) {
    for (std::size_t i = 0; i < truth.exitance[f].size(); ++i) {
      const double off = result.exitance[f][i] - truth.exitance[f][i];
      distance += off * off;
      size += truth.exitance[f][i] * truth.exitance[f][i];
    }
  }
  return std::sqrt(distance / size);
}

/// (leaving + absorbed) / entering of the first pattern.
double accounted_for(const ForwardResult& result) {
  const forward::PowerBalance& b = result.balance.front();
  return (std::accumulate(b.exiting.begin(), b.exiting.end(), 0.0) + b.unscattered + b.absorbed) /
         b.entering;
}

}  // namespace

Json limit_stencil(const Request& request, Progress& progress) {
  Json rows = Json::array();
  struct Case {
    const char* name;
    GridShape shape;
    MediumKind kind;
    int period;
  };
  const GridShape coarse{32, 32, 20, 0.25};
  const std::array<Case, 6> blocks{{
      {"smooth", coarse, MediumKind::smooth, 1},
      {"smooth, voxels halved", coarse.refined(2), MediumKind::smooth, 1},
      {"inclusions", coarse, MediumKind::inclusions, 1},
      {"layers of 1 mm", coarse, MediumKind::layers, 4},
      {"layers of 1 mm, voxels halved", coarse.refined(2), MediumKind::layers, 8},
      {"random cubes of 1 mm", coarse, MediumKind::random, 4},
  }};
  for (const auto& [name, shape, kind, period] : blocks) {
    for (const double contrast : {1.0, 2.0, 1e1, 1e2, 1e4}) {
      progress.update("stencil", 0.0, name);
      const ForwardProblem problem =
          problem_of(shape, {.kind = kind, .contrast = contrast, .period = period});
      const ForwardResult ours = answer("multigrid", problem, {1e-6, 200}, request);
      const ForwardResult theirs = answer("wang2008-stencil", problem, {1e-6, 20000}, request);
      rows.push_back({{"κ", name},
                      {"contrast", contrast},
                      {"accounted for by (8)", accounted_for(theirs)},
                      {"distance of the maps", exitance_error(theirs, ours)},
                      {"(8) ended", to_string(theirs.termination)}});
    }
  }
  return rows;
}

Json limit_relaxation(const Request& request, Progress& progress) {
  Json rows = Json::array();
  struct Case {
    const char* name;
    GridShape shape;
    MediumSpec medium;
  };
  const std::array<Case, 4> blocks{{
      {"16³, even κ", {16, 16, 16, 0.5}, {}},
      {"32³, even κ", {32, 32, 32, 0.25}, {}},
      {"64³, even κ", {64, 64, 64, 0.125}, {}},
      {"32³, inclusions of contrast 1e4",
       {32, 32, 32, 0.25},
       {.kind = MediumKind::inclusions, .contrast = 1e4}},
  }};
  for (const Case& block : blocks) {
    const ForwardProblem problem = problem_of(block.shape, block.medium);
    const ForwardResult truth = answer("multigrid", problem, {1e-6, 200}, request);
    for (const char* method : {"relaxation", "gauss-seidel"}) {
      for (const int sweeps : {16, 128, 1024, 8192}) {
        progress.update("relaxation", 0.0, std::string(block.name) + " " + method);
        const ForwardResult result = answer(method, problem, {1e-14, sweeps}, request);
        rows.push_back(
            {{"block", block.name},
             {"method", method},
             {"sweeps", sweeps},
             {"residual", *std::max_element(result.residual.begin(), result.residual.end())},
             {"error of the maps", exitance_error(result, truth)}});
      }
    }
  }
  return rows;
}

}  // namespace kappamu::studies
