#include "forward/embedded/embedded_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <sstream>

#include "core/error.h"
#include "core/process_memory.h"
#include "forward/embedded/bodies.h"
#include "forward/embedded/discretisation.h"
#include "forward/embedded/refinement.h"

namespace kappamu::forward {

namespace {

using namespace embedded;

/// Surface cubes of the first mesh: the object's longest extent over 2^level.
constexpr int first_level = 4;
/// A mesh starts with its folded cubes split as often as this.
constexpr int fold_splits = 2;
/// Of the indicator's sum, the share that a refinement splits.
constexpr double refined_share = 0.8;
/// Exitance on a mesh and on the same with every cube split differ by 3 times the finer's error where
/// the error falls with h², by less at edges of the light. Between the two, on the safe side of
/// measured errors.
constexpr double difference_per_error = 2.0;
/// Memory that a cube takes with its share of the hierarchy and of eight lights [bytes], measured.
constexpr double bytes_per_cube = 2600.0;
constexpr double usable_memory = 0.7;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Norms on the surface: √(∫ (a − b)² dA).
double difference(const Surface& surface, const std::vector<double>& a,
                  const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    sum += surface.area[t] * (a[t] - b[t]) * (a[t] - b[t]);
  }
  return std::sqrt(sum);
}

double norm(const Surface& surface, const std::vector<double>& a) {
  return difference(surface, a, std::vector<double>(a.size(), 0.0));
}

/// The answer for one body on its last mesh.
struct BodyAnswer {
  Answer answer;
  std::vector<double> error;  ///< per light: estimated 2-norm of the exitance's error
  std::size_t cubes = 0;
  double setup_seconds = 0.0, seconds = 0.0;
  bool within_tolerance = false, converged = true;
  int slits = 0;  ///< bridged by cubes of the last mesh
};

class BodySolve {
 public:
  BodySolve(const ObjectProblem& problem, const ObjectOptions& options, Progress& progress)
      : problem_(problem), options_(options), progress_(progress) {
    const double memory = usable_memory * main_memory() / bytes_per_cube;
    most_cubes_ = options.max_elements ? static_cast<std::size_t>(*options.max_elements)
                                       : static_cast<std::size_t>(memory);
  }

  BodyAnswer run() {
    Octree tree(problem_.mesh);
    tree.refine_surface(first_level);
    split_folds(tree);
    BodyAnswer best;
    for (int step = 0;; ++step) {
      // The mesh and the same with every cube split: two resolutions, one error.
      CutMesh coarse_mesh = cut_mesh(tree, problem_.mesh, problem_.rays);
      Octree fine_tree = tree;
      fine_tree.refine_each(coarse_mesh.leaf);
      CutMesh fine_mesh = cut_mesh(fine_tree, problem_.mesh, problem_.rays);
      if (fine_mesh.cubes.size() > most_cubes_) {
        if (step == 0) refuse(fine_mesh.cubes.size());
        return best;
      }
      const std::vector<std::vector<double>> coarse =
          solved(Discretisation(tree, std::move(coarse_mesh), problem_.medium, constants_.A))
              .exitance;
      const Discretisation fine(std::move(fine_tree), std::move(fine_mesh), problem_.medium,
                                constants_.A);
      best.answer = solved(fine);
      best.cubes = fine.mesh.cubes.size();
      best.slits = folds(fine.mesh, problem_.surface).slits;
      best.converged = best.answer.report.converged;
      best.error.clear();
      double worst = 0.0;
      for (std::size_t l = 0; l < coarse.size(); ++l) {
        const std::vector<double>& exitance = best.answer.exitance[l];
        best.error.push_back(difference(problem_.surface, exitance, coarse[l]) /
                             difference_per_error);
        const double size = norm(problem_.surface, exitance);
        if (size > 0.0) worst = std::max(worst, best.error.back() / size);
      }
      best.within_tolerance = worst <= options_.tolerance;
      best.setup_seconds = seconds_since(start_) - solving_;
      best.seconds = solving_;
      report(worst, best.cubes);
      if (best.within_tolerance) return best;
      tree.refine(largest(gradient_indicator(fine.tree, fine.mesh, fine.hierarchy.space,
                                             fine.coefficients, best.answer.fluence),
                          refined_share));
    }
  }

 private:
  void split_folds(Octree& tree) const {
    for (int split = 0; split < fold_splits; ++split) {
      tree.refine(folds(cut_mesh(tree, problem_.mesh, problem_.rays), problem_.surface).leaf);
    }
  }

  Answer solved(const Discretisation& discretisation) {
    const auto start = std::chrono::steady_clock::now();
    Answer result = answer(discretisation, problem_, constants_);
    solving_ += seconds_since(start);
    return result;
  }

  void report(double worst, std::size_t cubes) const {
    std::ostringstream detail;
    detail << cubes << " cubes, error " << worst;
    progress_.update("embedded", std::min(1.0, options_.tolerance / std::max(worst, 1e-300)),
                     detail.str());
  }

  [[noreturn]] void refuse(std::size_t cubes) const {
    throw InputError("the object's surface asks for at least " + std::to_string(cubes) +
                     " cubes (" + gigabytes(bytes_per_cube * static_cast<double>(cubes)) +
                     ") but " + std::to_string(most_cubes_) +
                     (options_.max_elements ? " are allowed; raise max_elements"
                                            : " fit this machine's memory") +
                     " or simplify the mesh");
  }

  const ObjectProblem& problem_;
  const ObjectOptions& options_;
  Progress& progress_;
  const BoundaryConstants constants_ = boundary_constants(problem_.eta);
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double solving_ = 0.0;
  std::size_t most_cubes_ = 0;
};

void require(bool holds, const std::string& sentence) {
  if (!holds) throw InputError(sentence);
}

void validate(const ObjectProblem& problem, const ObjectOptions& options) {
  require(!problem.mesh.triangles.empty(), "the mesh has no triangles; give a closed mesh");
  for (std::size_t v = 0; v < problem.mesh.vertices.size(); ++v) {
    require(problem.mesh.vertices[v].allFinite(),
            "vertex " + std::to_string(v) + " of the mesh is not finite; mend the mesh file");
  }
  require(problem.surface.size() == problem.mesh.triangles.size(),
          "the surface has " + std::to_string(problem.surface.size()) + " samples but the mesh " +
              std::to_string(problem.mesh.triangles.size()) + " triangles");
  require(bounding_box(problem.mesh).sizes().maxCoeff() > 0.0,
          "the mesh has no extent; give a closed mesh");
  require(enclosed_volume(problem.mesh) > 0.0,
          "the mesh encloses no volume; its triangles must be counter-clockwise seen from outside");
  require(options.tolerance > 0.0 && options.tolerance < 1.0,
          "the tolerance must lie between 0 and 1");
  const Coefficients least = problem.medium.smallest(), most = problem.medium.largest();
  require(least.kappa > 0.0 && std::isfinite(most.kappa), "kappa must be positive and finite");
  require(least.mu >= 0.0 && std::isfinite(most.mu), "mu must be finite and not negative");
  for (std::size_t l = 0; l < problem.lights.size(); ++l) {
    const ObjectLight& light = problem.lights[l];
    require(light.diffuse.empty() || light.diffuse.size() == problem.surface.size(),
            "light " + std::to_string(l) + " has " + std::to_string(light.diffuse.size()) +
                " irradiances for " + std::to_string(problem.surface.size()) +
                " surface samples");
    for (const Beam& beam : light.beams) {
      require(beam.triangle >= 0 && beam.triangle < static_cast<int>(problem.surface.size()),
              "a beam of light " + std::to_string(l) + " names triangle " +
                  std::to_string(beam.triangle) + ", which the mesh does not have");
    }
  }
}

/// The body's own lights.
std::vector<ObjectLight> lights_of(const Body& body, const std::vector<int>& local,
                                   const std::vector<ObjectLight>& lights) {
  std::vector<ObjectLight> result;
  for (const ObjectLight& light : lights) {
    ObjectLight mine;
    for (Beam beam : light.beams) {
      beam.triangle = local[static_cast<std::size_t>(beam.triangle)];
      if (beam.triangle >= 0) mine.beams.push_back(beam);
    }
    if (!light.diffuse.empty()) {
      for (const int t : body.triangle) {
        mine.diffuse.push_back(light.diffuse[static_cast<std::size_t>(t)]);
      }
    }
    result.push_back(std::move(mine));
  }
  return result;
}

/// Adds a body's answer to the object's. `error_estimate` collects squares until all are in.
void add(const Body& body, const BodyAnswer& part, std::size_t samples, ObjectResult& result) {
  for (std::size_t l = 0; l < part.answer.exitance.size(); ++l) {
    for (std::size_t t = 0; t < body.triangle.size(); ++t) {
      result.exitance[l * samples + static_cast<std::size_t>(body.triangle[t])] =
          part.answer.exitance[l][t];
    }
    result.error_estimate[l] += part.error[l] * part.error[l];
    const ObjectBalance& from = part.answer.balance[l];
    ObjectBalance& to = result.balance[l];
    to.entering += from.entering;
    to.unscattered += from.unscattered;
    to.exiting += from.exiting;
    to.absorbed += from.absorbed;
  }
  result.elements += part.cubes;
  result.iterations = std::max(result.iterations, part.answer.report.iterations);
  result.setup_seconds += part.setup_seconds;
  result.seconds += part.seconds;
}

}  // namespace

ObjectResult EmbeddedModel::solve(const ObjectProblem& problem, const ObjectOptions& options,
                                  Progress& progress) {
  validate(problem, options);
  const std::size_t samples = problem.surface.size(), lights = problem.lights.size();
  ObjectResult result;
  result.exitance.assign(lights * samples, 0.0);
  result.error_estimate.assign(lights, 0.0);
  result.balance.resize(lights);
  bool within_tolerance = true, solved = true;
  int slits = 0;
  for (const Body& body : bodies(problem.mesh, problem.rays)) {
    std::vector<int> local(samples, -1);
    for (std::size_t t = 0; t < body.triangle.size(); ++t) {
      local[static_cast<std::size_t>(body.triangle[t])] = static_cast<int>(t);
    }
    const Surface surface = surface_of(body.mesh);
    const std::vector<ObjectLight> own = lights_of(body, local, problem.lights);
    const BodyRays rays(problem.rays, std::move(local));
    const ObjectProblem part{body.mesh, surface, rays, problem.medium, problem.eta, own};
    const BodyAnswer answer = BodySolve(part, options, progress).run();
    add(body, answer, samples, result);
    within_tolerance = within_tolerance && answer.within_tolerance;
    solved = solved && answer.converged;
    slits += answer.slits;
  }
  for (std::size_t l = 0; l < lights; ++l) {
    const std::vector<double> exitance(
        result.exitance.begin() + static_cast<std::ptrdiff_t>(l * samples),
        result.exitance.begin() + static_cast<std::ptrdiff_t>((l + 1) * samples));
    const double size = norm(problem.surface, exitance);
    result.error_estimate[l] = size > 0.0 ? std::sqrt(result.error_estimate[l]) / size : 0.0;
  }
  result.converged = within_tolerance && solved;
  std::ostringstream estimate;
  estimate << (lights == 0 ? 0.0
                           : *std::max_element(result.error_estimate.begin(),
                                               result.error_estimate.end()));
  if (!solved) {
    result.message = "the linear solver stopped before its tolerance";
  } else if (!within_tolerance) {
    result.message = "stopped at " + std::to_string(result.elements) +
                     " cubes, the most allowed, with an estimated error of " + estimate.str();
  } else {
    result.message = "the estimated error " + estimate.str() + " is within the tolerance";
  }
  if (!result.converged) result.warnings.push_back(result.message);
  if (slits > 0) {
    result.warnings.push_back(
        std::to_string(slits) +
        " cubes bridge slits of the object narrower than themselves; light crosses there that "
        "should not, and the error estimate may not include it");
  }
  return result;
}

}  // namespace kappamu::forward
