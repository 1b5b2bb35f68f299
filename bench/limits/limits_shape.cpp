// Shapes of the block, and what its surface does to the equations.
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/cases/limit_case.h"
#include "bench/limits/limits.h"

namespace kappamu::bench {

namespace {

std::string name_of(const GridShape& s) {
  return std::to_string(s.nx) + "×" + std::to_string(s.ny) + "×" + std::to_string(s.nz);
}

}  // namespace

void limit_shape(const Request& request, Progress& progress, const Save& save) {
  Json rows = Json::array();
  constexpr std::array<GridShape, 20> shapes{{
      {48, 48, 1, 0.25},   {48, 48, 2, 0.25},  {48, 48, 3, 0.25},   {48, 48, 4, 0.25},
      {1, 48, 48, 0.25},   {2, 48, 48, 0.25},  {48, 3, 48, 0.25},   {48, 4, 48, 0.25},
      {31, 37, 41, 0.25},  {127, 61, 7, 0.25}, {1000, 7, 3, 0.25},  {7, 1000, 3, 0.25},
      {3, 7, 1000, 0.25},  {1, 1, 2000, 0.25}, {2000, 1, 1, 0.25},  {1, 1, 1, 0.25},
      {257, 129, 5, 0.25}, {33, 33, 33, 0.25}, {512, 16, 16, 0.25}, {16, 16, 512, 0.25},
  }};
  for (const GridShape& shape : shapes) {
    for (const double contrast : {1e1, 1e4}) {
      progress.update("shape", 0.0, name_of(shape));
      const LimitOutcome outcome =
          run_limit({.setup = {.shape = shape},
                     .medium = {.kind = MediumKind::random, .contrast = contrast},
                     .options = {1e-6, 200},
                     .device = request.device});
      rows.push_back({{"voxels", name_of(shape)},
                      {"contrast", contrast},
                      {"iterations", outcome.iterations},
                      {"true error", *outcome.true_error},
                      {"imbalance", outcome.imbalance},
                      {"ended", to_string(outcome.termination)}});
    }
  }
  save({{"rows", rows}});
}

void limit_mirror(const Request& request, Progress& progress, const Save& save) {
  Json rows = Json::array();
  for (const double kappa : {1e-3, 0.3, 1e3}) {
    for (const int depth : {1, 16, 256, 2048}) {
      progress.update("mirror", 0.0, std::to_string(depth));
      const LimitOutcome outcome = run_limit({.setup = {.shape = {8, 8, depth, 0.25},
                                                        .sides = Sides::mirror,
                                                        .source = forward::SourceModel::boundary},
                                              .medium = {.mean_kappa = kappa, .mu = 0.0},
                                              .options = {1e-6, 200},
                                              .device = request.device});
      rows.push_back({{"κ [mm]", kappa},
                      {"voxels deep", depth},
                      {"iterations", outcome.iterations},
                      {"true error", *outcome.true_error},
                      {"imbalance", outcome.imbalance},
                      {"ended", to_string(outcome.termination)}});
    }
  }
  save({{"rows", rows}});
}

void limit_boundary(const Request& request, Progress& progress, const Save& save) {
  Json rows = Json::array();
  for (const double ratio : {1e-6, 1e-3, 1e-1, 1e1, 1e3, 1e6}) {
    progress.update("boundary", 0.0, Json(ratio).dump());
    // The inside stays as it is; κ of the outermost voxels is `ratio` times it.
    const GridShape shape{32, 32, 20, 0.25};
    const double inside = 30.0 * 30.0 * 18.0 / static_cast<double>(shape.cells());
    const double mean = 0.3 * std::pow(ratio, 1.0 - inside);
    const LimitOutcome outcome = run_limit(
        {.setup = {.shape = shape, .source = forward::SourceModel::boundary},
         .medium = {.kind = MediumKind::shell, .contrast = 1.0 / ratio, .mean_kappa = mean},
         .options = {1e-6, 200},
         .device = request.device});
    rows.push_back({{"κ outermost / inside", ratio},
                    {"iterations", outcome.iterations},
                    {"true error", *outcome.true_error},
                    {"error of the unlit face", *outcome.dark_error},
                    {"imbalance", outcome.imbalance},
                    {"ended", to_string(outcome.termination)}});
  }
  save({{"rows", rows}});
}

}  // namespace kappamu::bench
