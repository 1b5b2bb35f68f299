#include "forward/embedded/body_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <sstream>

#include "core/error.h"
#include "core/mesh/surface_norm.h"
#include "core/process_memory.h"
#include "forward/embedded/refinement.h"
#include "forward/embedded/solver_choice.h"

namespace kappamu::forward::embedded {

namespace {

/// Surface cubes of the first mesh: the object's longest extent over 2^level.
constexpr int first_level = 4;
/// A mesh starts with its folded cubes split as often as this.
constexpr int fold_splits = 1;
/// Of the indicator's sum, the share that a refinement splits at most and at least, and the error
/// aimed at, of the tolerance.
constexpr double most_refined = 0.8, least_refined = 0.3, aimed_at = 0.9;
/// Exitance on a mesh and on the same with every cube split differ by 3 times the finer's error
/// where the error falls with h², by less at edges of the light. Between the two, on the safe side
/// of measured errors.
constexpr double difference_per_error = 2.0;
/// Where κ jumps inside cubes it falls with h, and what halving h takes away is what is left.
constexpr double difference_per_error_at_jumps = 1.0;
/// Memory that a cube takes with its share of the levels, of every channel's numbers there and of
/// every light that is solved for at once [bytes], measured.
constexpr double bytes_per_cube = 1700.0, bytes_per_channel = 350.0, bytes_per_light = 150.0;
constexpr std::size_t lights_at_once = 8;
constexpr double usable_memory = 0.7;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class BodySolve {
 public:
  BodySolve(std::span<const ObjectProblem> problems, const ObjectOptions& options,
            Progress& progress)
      : channels_(problems), problem_(problems[0]), options_(options), progress_(progress) {
    const double memory = usable_memory * main_memory() / bytes_each();
    most_cubes_ = options.max_elements ? static_cast<std::size_t>(*options.max_elements)
                                       : static_cast<std::size_t>(memory);
  }

  BodyAnswer run() {
    progress_.update("embedded", 0.0,
                     "at most " + std::to_string(most_cubes_) + " cubes, " +
                         gigabytes(bytes_each() * static_cast<double>(most_cubes_)));
    Octree tree(problem_.mesh);
    tree.refine_surface(first_level);
    CutMesh coarse_mesh = with_folds_split(tree);
    BodyAnswer best;
    for (int step = 0;; ++step) {
      // The mesh and the same with every cube split: two resolutions, one error.
      // Made side by side: what one does on a single core, the other fills up.
      auto finer = std::async(std::launch::async, [&, leaves = coarse_mesh.leaf] {
        return split_everywhere(tree, leaves, step == 0);
      });
      const Answers coarse = solved(discretised(tree, std::move(coarse_mesh)));
      const std::unique_ptr<const Discretisation> made = finer.get();
      if (!made) return best;
      const Discretisation& fine = *made;
      Answers found = solved(fine);
      best.channel = std::move(found.channel);
      best.cubes = fine.mesh.cubes.size();
      best.slits = folds(fine.mesh, problem_.surface).slits;
      best.iterations = found.report.iterations;
      best.solved = found.report.converged;
      const double worst = estimate(coarse, best);
      best.within_tolerance = worst <= options_.tolerance;
      best.setup_seconds = seconds_since(start_) - solving_;
      best.seconds = solving_;
      report(worst, best.cubes);
      if (best.within_tolerance) return best;
      tree.refine(largest(gradient_indicator(fine, best.channel), refined_share(worst)));
      coarse_mesh = cut_mesh(tree, problem_.mesh, problem_.rays);
    }
  }

 private:
  /// Splitting cubes quarters their share of the error.
  double refined_share(double error) const {
    const double wanted = aimed_at * options_.tolerance / error;
    return std::clamp((1.0 - wanted) / 0.75, least_refined, most_refined);
  }

  /// Memory per cube.
  double bytes_each() const {
    return bytes_per_cube + bytes_per_channel * static_cast<double>(channels_.problems.size()) +
           bytes_per_light * static_cast<double>(std::min(channels_.lights(), lights_at_once));
  }

  CutMesh with_folds_split(Octree& tree) const {
    CutMesh mesh = cut_mesh(tree, problem_.mesh, problem_.rays);
    for (int split = 0; split < fold_splits; ++split) {
      const std::vector<int> folded = folds(mesh, problem_.surface).leaf;
      if (folded.empty()) break;
      tree.refine(folded);
      mesh = cut_mesh(tree, problem_.mesh, problem_.rays);
    }
    return mesh;
  }

  Discretisation discretised(Octree tree, CutMesh mesh) const {
    return Discretisation(std::move(tree), std::move(mesh), channels_.media(),
                          channels_.constants.A);
  }

  /// With each of the leaves split; none where that is too large. What is asked for first is
  /// refused then.
  std::unique_ptr<const Discretisation> split_everywhere(Octree tree,
                                                         const std::vector<int>& leaves,
                                                         bool first) const {
    tree.refine_each(leaves);
    CutMesh mesh = cut_mesh(tree, problem_.mesh, problem_.rays);
    if (mesh.cubes.size() > most_cubes_) {
      if (first) refuse(mesh.cubes.size());
      return nullptr;
    }
    return std::make_unique<const Discretisation>(discretised(std::move(tree), std::move(mesh)));
  }

  Answers solved(const Discretisation& discretisation) {
    const auto start = std::chrono::steady_clock::now();
    Answers result =
        answers(discretisation, channels_,
                *make_linear_solver(discretisation.levels, channels_.lights(), options_.device),
                linear_tolerance(options_.tolerance));
    solving_ += seconds_since(start);
    return result;
  }

  /// Fills in the errors; the largest relative one.
  double estimate(const Answers& coarse, BodyAnswer& best) const {
    best.error.assign(best.channel.size(), {});
    double worst = 0.0;
    for (std::size_t c = 0; c < best.channel.size(); ++c) {
      const double per_error = channels_.problems[c].medium.homogeneous()
                                   ? difference_per_error
                                   : difference_per_error_at_jumps;
      for (std::size_t l = 0; l < best.channel[c].exitance.size(); ++l) {
        const std::vector<double>& exitance = best.channel[c].exitance[l];
        const double error =
            surface_difference(problem_.surface, exitance, coarse.channel[c].exitance[l]) /
            per_error;
        best.error[c].push_back(error);
        const double size = surface_norm(problem_.surface, exitance);
        if (size > 0.0) worst = std::max(worst, error / size);
      }
    }
    return worst;
  }

  void report(double worst, std::size_t cubes) const {
    std::ostringstream detail;
    detail << cubes << " cubes, error " << worst;
    progress_.update("embedded", std::min(1.0, options_.tolerance / std::max(worst, 1e-300)),
                     detail.str());
  }

  [[noreturn]] void refuse(std::size_t cubes) const {
    throw InputError("the object's surface asks for at least " + std::to_string(cubes) +
                     " cubes (" + gigabytes(bytes_each() * static_cast<double>(cubes)) + ") but " +
                     std::to_string(most_cubes_) +
                     (options_.max_elements ? " are allowed; raise max_elements"
                                            : " fit this machine's memory") +
                     " or simplify the mesh");
  }

  const Channels channels_;
  const ObjectProblem& problem_;  ///< of the first channel: shape, surface and rays of all
  const ObjectOptions& options_;
  Progress& progress_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double solving_ = 0.0;
  std::size_t most_cubes_ = 0;
};

}  // namespace

BodyAnswer solve_body(std::span<const ObjectProblem> problems, const ObjectOptions& options,
                      Progress& progress) {
  return BodySolve(problems, options, progress).run();
}

}  // namespace kappamu::forward::embedded
