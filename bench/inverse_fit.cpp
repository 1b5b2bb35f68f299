#include "bench/inverse_fit.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/record.h"
#include "core/error.h"
#include "inverse/problem/problem.h"
#include "inverse/validation/validated_fit.h"

namespace kappamu::bench {

namespace {

using Json = nlohmann::ordered_json;
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
  // Grids halve from one to the next, odd extents rounded up: walk back up the same ladder.
  std::vector<GridShape> ladder{grid};
  while (!(ladder.back() == shape)) {
    const GridShape& s = ladder.back();
    check(s.nx > shape.nx || s.ny > shape.ny || s.nz > shape.nz,
          "a course names a grid the ladder does not have");
    ladder.push_back({(s.nx + 1) / 2, (s.ny + 1) / 2, (s.nz + 1) / 2, 2.0 * s.voxel_mm});
  }
  for (std::size_t k = ladder.size(); k-- > 1;) {
    fields = {inverse::prolong(fields.log_kappa, ladder[k], ladder[k - 1]),
              inverse::prolong(fields.log_mu, ladder[k], ladder[k - 1])};
  }
  return inverse::to_medium(fields, grid);
}

double work_of(const inverse::SolveCount& solves, const GridShape& grid) {
  return solves.voxel_iterations / static_cast<double>(grid.cells());
}

Json to_json(const CoursePoint& p) {
  return {{"solves", p.solves}, {"work", p.work},   {"seconds", p.seconds}, {"weight", p.weight},
          {"chi2", p.chi2},     {"level", p.level}, {"holdout_E", p.error}};
}

}  // namespace

std::vector<Way> inverse_ways() {
  std::vector<Way> ways;
  ways.push_back({"default", "L-BFGS, informed (default)", {}});
  const auto add = [&](const char* name, const char* label, inverse::Coordinates coordinates,
                       inverse::Method method) -> Way& {
    Way way{name, label, {}};
    way.options.coordinates = coordinates;
    way.options.optimiser.method = method;
    ways.push_back(way);
    return ways.back();
  };
  using inverse::Coordinates;
  using inverse::Method;
  add("smooth", "L-BFGS, smooth", Coordinates::smooth, Method::lbfgs);
  add("voxels", "L-BFGS, voxels", Coordinates::voxels, Method::lbfgs);
  add("gauss-newton", "Gauss-Newton-CG, informed", Coordinates::informed, Method::gauss_newton);
  add("wang2008", "[W]'s optimiser, our course", Coordinates::voxels, Method::wang2008);
  Way& scheme = add("wang2008-scheme", "[W]'s scheme: one grid, one weight", Coordinates::voxels,
                    Method::wang2008);
  scheme.options.model = inverse::Model::volume;
  scheme.options.max_levels = 1;
  scheme.options.stage_tolerance = 1e-5;
  scheme.options.stage_steps = 200;
  scheme.weight_of_default = true;
  // The same as [W] prints it: their regulariser at their λ, data unweighted, nothing corrected.
  Way printed{"wang2008-printed", "[W]'s scheme as printed, λ = 1e-5", scheme.options};
  printed.options.regulariser.kind = inverse::RegulariserKind::wang2008;
  printed.options.weight = 1e-5;
  printed.options.correct_grid = false;
  ways.push_back(std::move(printed));
  return ways;
}

Judge make_judge(const Block& block, CoefficientPair fine_fields, int single_sources) {
  Judge judge;
  judge.patches = expose_patches(block, fine_fields, 8);
  constexpr std::uint64_t seed = 11;
  judge.single =
      expose(block, fine_fields,
             single_voxel_light(face_shape(block.grid, block.lit), single_sources, seed));
  judge.fine_fields = std::move(fine_fields);
  return judge;
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

FitScore measure_fit(const SurfaceMeasurements& m, const Judge& judge, const FitOptions& options,
                     Judged judged, int course_points, Progress& progress) {
  std::vector<Snapshot> kept;
  const double ratio = course_ratio(course_points);
  const inverse::Observer observer = [&](const inverse::StepRecord& record, const GridShape& shape,
                                         const CoefficientPair& fields) {
    if (!kept.empty() && record.solves.total() < ratio * kept.back().record.solves.total()) return;
    kept.push_back({record, shape, fields});
  };
  const int kept_out = judged == Judged::no ? 0 : inverse::usual_held_out(m.patterns);
  const inverse::ChannelFit fit =
      inverse::fit_judged(inverse::keep_out(m, inverse::choose_held_out(m, kept_out)), 0, options,
                          {}, {}, progress, course_points > 0 ? observer : inverse::Observer{})
          .fit;
  FitScore score;
  score.grid = m.grid;
  score.patterns = m.patterns;
  score.status = to_string(fit.report.status);
  score.backend = fit.report.backend;
  const inverse::SolveCount& solves = fit.report.solves;
  score.solves = solves.total();
  score.work = work_of(solves, m.grid);
  score.seconds = fit.report.seconds;
  score.chi2 = fit.report.chi2_per_value;
  score.weight = fit.report.weight;
  score.patches_error = appearance_error(fit.medium, judge.patches);
  score.single_error = appearance_error(fit.medium, judge.single);
  score.depth = depth_error(fit.medium, judge.fine_fields, m.lit_face);
  for (Snapshot& s : kept) {
    const inverse::StepRecord& r = s.record;
    score.course.push_back(
        {r.solves.total(), work_of(r.solves, m.grid), r.seconds, r.weight, r.chi2_per_value,
         r.level, appearance_error(exported(m.grid, s.shape, std::move(s.fields)), judge.patches)});
  }
  if (course_points > 0) {
    score.course.push_back({score.solves, score.work, score.seconds, score.weight, score.chi2, 0,
                            score.patches_error});
  }
  return score;
}

const CoursePoint* first_to_reach(const std::vector<CoursePoint>& course, double error) {
  const auto found = std::find_if(course.begin(), course.end(),
                                  [&](const CoursePoint& p) { return p.error <= error; });
  return found == course.end() ? nullptr : &*found;
}

Json to_json(const FitScore& s) {
  Json course = Json::array();
  for (const CoursePoint& p : s.course) course.push_back(to_json(p));
  return {{"way", s.way},
          {"grid", {s.grid.nx, s.grid.ny, s.grid.nz}},
          {"voxel_mm", s.grid.voxel_mm},
          {"patterns", s.patterns},
          {"noise", s.noise},
          {"status", s.status},
          {"device", s.backend},
          {"batched_solves", s.solves},
          {"work", s.work},
          {"seconds", s.seconds},
          {"data_misfit_chi2", s.chi2},
          {"weight", s.weight},
          {"holdout_E", s.patches_error},
          {"single_voxel_E", s.single_error},
          {"kappa_error_by_depth", s.depth.kappa},
          {"mu_error_by_depth", s.depth.mu},
          {"course", course}};
}

FitScore fit_score_from_json(const Json& o) {
  FitScore s;
  s.way = o.at("way").get<std::string>();
  const auto grid = o.at("grid").get<std::vector<int>>();
  s.grid = {grid.at(0), grid.at(1), grid.at(2), o.at("voxel_mm").get<double>()};
  s.patterns = o.at("patterns").get<int>();
  s.noise = o.at("noise").get<double>();
  s.status = o.at("status").get<std::string>();
  s.backend = o.at("device").get<std::string>();
  s.solves = o.at("batched_solves").get<int>();
  s.work = o.at("work").get<double>();
  s.seconds = o.at("seconds").get<double>();
  s.chi2 = o.at("data_misfit_chi2").get<double>();
  s.weight = o.at("weight").get<double>();
  s.patches_error = o.at("holdout_E").get<double>();
  s.single_error = o.at("single_voxel_E").get<double>();
  s.depth.kappa = o.at("kappa_error_by_depth").get<std::vector<double>>();
  s.depth.mu = o.at("mu_error_by_depth").get<std::vector<double>>();
  for (const Json& p : o.at("course")) {
    s.course.push_back({p.at("solves").get<int>(), p.at("work").get<double>(),
                        p.at("seconds").get<double>(), p.at("weight").get<double>(),
                        p.at("chi2").get<double>(), p.at("level").get<int>(),
                        p.at("holdout_E").get<double>()});
  }
  return s;
}

}  // namespace kappamu::bench
