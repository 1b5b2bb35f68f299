#include "studies/objects/object_bench.h"

#include <nlohmann/json.hpp>

#include "core/mesh/surface_norm.h"
#include "forward/embedded/embedded_model.h"
#include "studies/objects/even_cubes.h"
#include "studies/objects/object_measurement.h"

namespace kappamu::studies {

namespace {

using namespace forward;

/// The exitances that all others are held against are made to this tolerance, with as many cubes at
/// most.
constexpr double reference_tolerance = 0.0015;
constexpr std::uint64_t reference_cubes = 2'000'000;
/// That is asked for; even cubes are solved for as tightly.
constexpr double finest_tolerance = 0.005;

struct Answered {
  std::vector<double> exitance;
  std::size_t cubes = 0;
  std::optional<double> stated;  ///< relative error
};

Answered on_even_cubes(const ObjectProblem& problem, int level, bool everywhere,
                       const std::string& device) {
  const EvenCubes cubes(problem, level, everywhere);
  embedded::Answers found = cubes.answers(*cubes.solver(device), finest_tolerance);
  return {std::move(found.channel[0].exitance[0]), cubes.count(), std::nullopt};
}

Answered refined(const ObjectProblem& problem, ObjectOptions options) {
  Progress quiet;
  ObjectResult result = EmbeddedModel().solve(problem, options, quiet);
  return {std::move(result.exitance), result.elements, result.error_estimate[0]};
}

/// What other answers are held against.
class FinestAnswer {
 public:
  FinestAnswer(const ObjectProblem& problem, ObjectOptions options, Size size) : problem_(problem) {
    options.tolerance = size == Size::full ? reference_tolerance : 0.02;
    options.max_elements = reference_cubes;
    answer_ = refined(problem, options);
    norm_ = surface_norm(problem.surface, answer_.exitance);
  }

  /// Fills in cubes, error and what is stated of it.
  void compare(const Answered& other, Json& row) const {
    row["elements"] = other.cubes;
    row["error"] = surface_difference(problem_.surface, other.exitance, answer_.exitance) / norm_;
    row["reference_error"] = *answer_.stated;
    if (other.stated) row["error_estimate"] = *other.stated;
  }

 private:
  ObjectProblem problem_;
  Answered answer_;
  double norm_ = 0.0;
};

std::vector<ObjectCase> cases_of_mesh_files(const Request& request, double size) {
  std::vector<ObjectCase> cases = cases_of_files(request.words("mesh"));
  std::erase_if(cases,
                [&](const ObjectCase& c) { return c.size != size || c.material != "marble"; });
  return cases;
}

}  // namespace

void measure_refinement(const Request& request, Progress& progress, const Save& save) {
  const ObjectSettings settings = object_settings(request);
  std::vector<ObjectCase> cases = object_cases(Population::tuning, {"nefertiti-marble-24"});
  for (const ObjectCase& own : cases_of_mesh_files(request, 24.0)) cases.push_back(own);
  std::vector<double> tolerances{0.1, 0.05, 0.02, 0.01, finest_tolerance};
  std::vector<int> levels{5, 6, 7, 8, 9};
  if (request.size != Size::full) {
    cases = object_cases(Population::tuning, {"sphere-marble-8-sky"});
    tolerances = {0.1, 0.05};
    levels = {3, 4};
  }
  Json rows = Json::array();
  for (const ObjectCase& object : cases) {
    const ObjectBench bench = make_object_bench(object, settings.meshes, settings.volume, progress);
    const ObjectProblem problem = bench.problem();
    ObjectOptions options;
    options.device = request.device;
    progress.update("reference", 0.0, object.name);
    const FinestAnswer reference(problem, options, request.size);
    const auto measure = [&](const std::string& cubes, const std::string& asked, auto&& solve) {
      progress.update(cubes, 0.0, object.name + ", " + asked);
      Json row{{"name", object.name}, {"cubes", cubes}, {"asked", asked}};
      const SpentTime spent;
      const Answered mine = solve();
      spent.record(row);
      reference.compare(mine, row);
      rows.push_back(std::move(row));
      save({{"rows", rows}});
    };
    // Kernels are compiled before they are timed.
    on_even_cubes(problem, levels.front(), false, options.device);
    for (const double tolerance : tolerances) {
      options.tolerance = tolerance;
      measure("refined by the estimate", "tolerance " + Json(tolerance).dump(),
              [&] { return refined(problem, options); });
    }
    for (const bool everywhere : {false, true}) {
      for (const int level : levels) {
        if (everywhere && level > 7) continue;  // tens of millions of cubes, most outside
        measure(everywhere ? "even everywhere" : "even at the surface",
                std::to_string(1 << level) + "³",
                [&] { return on_even_cubes(problem, level, everywhere, options.device); });
      }
    }
  }
}

void measure_estimates(const Request& request, Progress& progress, const Save& save) {
  const ObjectSettings settings = object_settings(request);
  std::vector<ObjectCase> cases = cases_of_files(request.words("mesh"));
  const auto add = [&](const std::vector<ObjectCase>& more) {
    cases.insert(cases.end(), more.begin(), more.end());
  };
  if (request.has("scenes")) {
    add(object_cases(Population::tuning, request.words("scenes")));
  } else {
    add(drawn_cases(request.count("draw", request.size == Size::full ? 24 : 2), request.seed));
  }
  std::vector<double> tolerances{0.02, 0.01, 0.005};
  if (request.size != Size::full) tolerances = {0.1, 0.05};
  Json rows = Json::array();
  for (const ObjectCase& object : cases) {
    progress.update("estimates", 0.0, object.name);
    const ObjectBench bench = make_object_bench(object, settings.meshes, settings.volume, progress);
    const ObjectProblem problem = bench.problem();
    ObjectOptions options;
    options.device = request.device;
    const FinestAnswer reference(problem, options, request.size);
    for (const double tolerance : tolerances) {
      options.tolerance = tolerance;
      Json row{{"name", object.name}, {"tolerance", tolerance}};
      const SpentTime spent;
      const Answered mine = refined(problem, options);
      spent.record(row);
      reference.compare(mine, row);
      rows.push_back(std::move(row));
      save({{"rows", rows}});
    }
  }
}

}  // namespace kappamu::studies
