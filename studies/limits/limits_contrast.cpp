// Contrast of κ: iterations, their growth with the grid, and what each precision can attain.
#include <array>

#include "studies/limits/limits.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using forward::Precision;

struct KappaField {
  const char* name;
  MediumSpec spec;
};

const std::vector<KappaField>& kappa_fields() {
  static const std::vector<KappaField> all{
      {"smooth", {.kind = MediumKind::smooth}},
      {"inclusions", {.kind = MediumKind::inclusions}},
      {"checkerboard, 1 voxel", {.kind = MediumKind::checkerboard}},
      {"checkerboard, 3 voxels", {.kind = MediumKind::checkerboard, .period = 3}},
      {"layers of 1 voxel across the light", {.kind = MediumKind::layers}},
      {"layers of 1 voxel along the light", {.kind = MediumKind::layers, .axis = 0}},
      {"random, 1 voxel", {.kind = MediumKind::random}},
      {"random, cubes of 3 voxels", {.kind = MediumKind::random, .period = 3}},
  };
  return all;
}

constexpr std::array<double, 4> contrasts{1.0, 1e1, 1e4, 1e6};

MediumSpec of_contrast(MediumSpec spec, double contrast) {
  spec.contrast = contrast;
  return spec;
}

/// `row` with what a solve is compared by.
Json with_outcome(Json row, const LimitOutcome& outcome) {
  row["iterations"] = outcome.iterations;
  if (outcome.true_error) row["true error"] = *outcome.true_error;
  row["ended"] = to_string(outcome.termination);
  return row;
}

}  // namespace

Json limit_contrast(const Request& request, Progress& progress) {
  Json rows = Json::array();
  for (const KappaField& material : kappa_fields()) {
    for (const double contrast : contrasts) {
      progress.update("contrast", 0.0, material.name);
      rows.push_back(with_outcome({{"κ", material.name}, {"contrast", contrast}},
                                  run_limit({.setup = {.shape = {48, 48, 20, 0.25}},
                                             .medium = of_contrast(material.spec, contrast),
                                             .patterns = 2,
                                             .device = request.device})));
    }
  }
  return rows;
}

Json limit_size(const Request& request, Progress& progress) {
  Json rows = Json::array();
  std::vector<int> edges{32, 64, 128};
  if (request.size == Size::full) edges.push_back(256);
  for (const KappaField& material : kappa_fields()) {
    if (material.spec.kind == MediumKind::smooth) continue;
    for (const double contrast : {1e4, 1e6}) {
      for (const int n : edges) {
        progress.update("size", 0.0, std::string(material.name) + " " + std::to_string(n));
        const LimitOutcome outcome = run_limit({.setup = {.shape = {n, n, n, 16.0 / n}},
                                                .medium = of_contrast(material.spec, contrast),
                                                .device = request.device,
                                                .with_error = false});
        rows.push_back(with_outcome(
            {{"κ", material.name}, {"contrast", contrast}, {"grid", std::to_string(n) + "³"}},
            outcome));
        // Where a small grid runs out, a larger one only takes longer to.
        if (outcome.termination != forward::Termination::converged) break;
      }
    }
  }
  return rows;
}

Json limit_floor(const Request& request, Progress& progress) {
  Json rows = Json::array();
  constexpr double out_of_reach = 1e-16;
  for (const KappaField& material : kappa_fields()) {
    for (const double contrast : contrasts) {
      progress.update("floor", 0.0, material.name);
      Json row{{"κ", material.name}, {"contrast", contrast}};
      for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
        const LimitOutcome outcome = run_limit({.setup = {.shape = {32, 32, 20, 0.25}},
                                                .medium = of_contrast(material.spec, contrast),
                                                .options = {out_of_reach, 200},
                                                .precision = precision,
                                                .device = request.device});
        const bool single = precision == Precision::single_precision;
        const std::string name = single ? ", single" : ", double";
        row["true error" + name] = *outcome.true_error;
        row["residual" + name] = outcome.residual;
        row["iterations" + name] = outcome.iterations;
        row["message" + name] = outcome.message;
      }
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace kappamu::studies
