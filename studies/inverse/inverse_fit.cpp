#include "studies/inverse/inverse_fit.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "inverse/problem/problem.h"
#include "inverse/validation/validated_fit.h"

namespace kappamu::studies {

using namespace test_cases;

namespace {

using inverse::CoefficientPair;
using inverse::FitOptions;

/// What an observer keeps of one step.
struct Snapshot {
  inverse::StepRecord record;
  GridShape shape;
  CoefficientPair fields;
};

/// Steps of the course: the next one kept has at least this many times the solves of the last.
double course_ratio(int points) {
  constexpr double most_solves = 3000.0;
  return std::pow(most_solves, 1.0 / std::max(1, points));
}

Medium exported(const GridShape& grid, GridShape shape, CoefficientPair fields) {
  // Grids halve from one to the next, odd extents rounded up: walk back up them.
  std::vector<GridShape> grids{grid};
  while (!(grids.back() == shape)) {
    const GridShape& s = grids.back();
    check(s.nx > shape.nx || s.ny > shape.ny || s.nz > shape.nz,
          "a history names a grid that halving does not give");
    grids.push_back({(s.nx + 1) / 2, (s.ny + 1) / 2, (s.nz + 1) / 2, 2.0 * s.voxel_mm});
  }
  for (std::size_t k = grids.size(); k-- > 1;) {
    fields = {inverse::prolong(fields.log_kappa, grids[k], grids[k - 1]),
              inverse::prolong(fields.log_mu, grids[k], grids[k - 1])};
  }
  return inverse::to_medium(fields, grid);
}

double work_of(const inverse::SolveCount& solves, const GridShape& grid) {
  return solves.voxel_iterations / static_cast<double>(grid.cells());
}

}  // namespace

std::vector<Variant> inverse_variants() {
  std::vector<Variant> variants;
  variants.push_back({"default", "L-BFGS, informed (default)", {}});
  const auto add = [&](const char* name, const char* label, inverse::Coordinates coordinates,
                       inverse::Method method) -> Variant& {
    Variant variant{name, label, {}};
    variant.options.solver.coordinates = coordinates;
    variant.options.solver.optimiser.method = method;
    variants.push_back(variant);
    return variants.back();
  };
  using inverse::Coordinates;
  using inverse::Method;
  add("smooth", "L-BFGS, smooth", Coordinates::smooth, Method::lbfgs);
  add("voxels", "L-BFGS, voxels", Coordinates::voxels, Method::lbfgs);
  add("wang2008", "[W]'s optimiser, our path", Coordinates::voxels, Method::wang2008);
  Variant& scheme = add("wang2008-scheme", "[W]'s scheme: one grid, one weight",
                        Coordinates::voxels, Method::wang2008);
  scheme.options.path.model = inverse::Model::volume;
  scheme.options.path.max_levels = 1;
  scheme.options.path.stage_tolerance = 1e-5;
  scheme.options.path.stage_steps = 200;
  scheme.weight_of_default = true;
  // The same as [W] prints it: their regulariser at their λ, data unweighted, nothing corrected.
  Variant printed{"wang2008-printed", "[W]'s scheme as printed, λ = 1e-5", scheme.options};
  printed.options.regulariser.kind = inverse::RegulariserKind::wang2008;
  printed.options.path.weight = 1e-5;
  printed.options.path.correct_grid = false;
  variants.push_back(std::move(printed));
  return variants;
}

Validation make_validation(const Block& block, CoefficientPair fine_fields, int single_sources) {
  Validation validation;
  validation.patches = expose_patches(block, fine_fields, 8);
  constexpr std::uint64_t seed = 11;
  validation.single =
      expose(block, fine_fields,
             single_voxel_light(face_shape(block.grid, block.lit), single_sources, seed));
  validation.fine_fields = std::move(fine_fields);
  return validation;
}

DepthError depth_error(const Medium& medium, const CoefficientPair& fine_fields, Face lit_face) {
  const GridShape& shape = medium.kappa.shape();
  const GridShape fine = shape.refined(2);
  const FaceShape face = face_shape(shape, lit_face);
  const auto mean_of = [&](const std::vector<double>& log, std::size_t cell) {
    const int x = static_cast<int>(cell) % shape.nx;
    const int y = static_cast<int>(cell) / shape.nx % shape.ny;
    const int z = static_cast<int>(cell) / shape.nx / shape.ny;
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      sum += std::exp(
          log[fine.index(2 * x + (corner & 1), 2 * y + (corner >> 1 & 1), 2 * z + (corner >> 2))]);
    }
    return sum / 8.0;
  };
  DepthError error;
  for (int depth = 0; depth < shape.extent(axis_of(lit_face)); ++depth) {
    std::vector<double> kappa, mu;
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        const std::size_t i = face_cell(shape, lit_face, u, v, depth);
        kappa.push_back(std::abs(medium.kappa[i] / mean_of(fine_fields.log_kappa, i) - 1.0));
        mu.push_back(std::abs(medium.mu[i] / mean_of(fine_fields.log_mu, i) - 1.0));
      }
    }
    error.kappa.push_back(median(std::move(kappa)));
    error.mu.push_back(median(std::move(mu)));
  }
  return error;
}

Json score_of(const inverse::ChannelFit& fit, const SurfaceMeasurements& m,
              const CoefficientPair& fine_fields) {
  const DepthError depth = depth_error(fit.medium, fine_fields, m.lit_face);
  return {{"grid", {m.grid.nx, m.grid.ny, m.grid.nz}},
          {"voxel_mm", m.grid.voxel_mm},
          {"patterns", m.patterns},
          {"status", to_string(fit.report.status)},
          {"device", fit.report.backend},
          {"batched_solves", fit.report.solves.total()},
          {"work", work_of(fit.report.solves, m.grid)},
          {"seconds", fit.report.seconds},
          {"data_misfit_chi2", fit.report.chi2_per_value},
          {"weight", fit.report.weight},
          {"kappa_error_by_depth", depth.kappa},
          {"mu_error_by_depth", depth.mu}};
}

Json measure_fit(const SurfaceMeasurements& m, const Validation& validation,
                 const FitOptions& options, KeptOut kept_out, int course_points,
                 Progress& progress) {
  std::vector<Snapshot> kept;
  const double ratio = course_ratio(course_points);
  const inverse::Observer observer = [&](const inverse::StepRecord& record, const GridShape& shape,
                                         const CoefficientPair& fields) {
    if (!kept.empty() && record.solves.total() < ratio * kept.back().record.solves.total()) return;
    kept.push_back({record, shape, fields});
  };
  const int apart = kept_out == KeptOut::none ? 0 : inverse::usual_validation_count(m.patterns);
  const inverse::ChannelFit fit =
      inverse::fit_validated(
          inverse::split_validation(m, inverse::choose_validation_patterns(m, apart)), 0, options,
          {}, {}, progress, course_points > 0 ? observer : inverse::Observer{})
          .fit;
  Json score = score_of(fit, m, validation.fine_fields);
  score["validation_E"] = appearance_error(fit.medium, validation.patches);
  score["single_voxel_E"] = appearance_error(fit.medium, validation.single);
  if (course_points <= 0) return score;
  for (Snapshot& s : kept) {
    const inverse::StepRecord& r = s.record;
    const Medium medium = exported(m.grid, s.shape, std::move(s.fields));
    score["course"].push_back({{"solves", r.solves.total()},
                               {"work", work_of(r.solves, m.grid)},
                               {"seconds", r.seconds},
                               {"weight", r.weight},
                               {"chi2", r.chi2_per_value},
                               {"level", r.level},
                               {"validation_E", appearance_error(medium, validation.patches)}});
  }
  score["course"].push_back({{"solves", score["batched_solves"]},
                             {"work", score["work"]},
                             {"seconds", score["seconds"]},
                             {"weight", score["weight"]},
                             {"chi2", score["data_misfit_chi2"]},
                             {"level", 0},
                             {"validation_E", score["validation_E"]}});
  return score;
}

}  // namespace kappamu::studies
