#include "forward/embedded/body_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <sstream>

#include "core/error.h"
#include "core/mesh/surface_norm.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "forward/embedded/narrow_places.h"
#include "forward/embedded/refinement.h"
#include "forward/embedded/solver_choice.h"

namespace kappamu::forward::embedded {

namespace {

/// Surface cubes of the first mesh: the object's longest extent over 2^level.
constexpr int first_level = 4;
/// Where beams enter it is finer: of cubes of edge h, which err by start_error (h/3κ)^start_order
/// as measured, the coarsest that err by start_excess tolerances.
constexpr double start_error = 0.016, start_order = 1.2, start_excess = 2.0;
/// Cubes on each h² of the surface, at least.
constexpr double cubes_per_square = 8.0;
/// A mesh starts with the cubes of folds and of parts thinner than they are split as often as this.
constexpr int narrow_splits = 1;
/// The error that a refinement aims at, of the tolerance and, at most, of the error before.
constexpr double aimed_at = 0.9, most_left = 0.85;
/// Share of the surface that may face another part of itself across less than a cube: more is
/// resolved where that can be done, however little two meshes differ.
constexpr double little_bridged = 0.05;
/// Memory that a cube takes with its share of the levels, of every channel's numbers there and of
/// every light that is solved for at once [bytes], measured.
constexpr double bytes_per_cube = 1300.0, bytes_per_channel = 1000.0, bytes_per_light = 150.0;
constexpr std::size_t lights_at_once = 8;

class BodySolve {
 public:
  BodySolve(std::span<const ObjectProblem> problems, const ObjectOptions& options, bool weighs_last,
            Progress& progress)
      : channels_(problems),
        problem_(problems[0]),
        options_(options),
        weighs_last_(weighs_last),
        progress_(progress) {
    const double memory = usable_memory() / bytes_each();
    most_cubes_ = options.max_elements ? static_cast<std::size_t>(*options.max_elements)
                                       : static_cast<std::size_t>(memory);
  }

  BodyAnswer run() {
    progress_.update("embedded", 0.0,
                     "at most " + std::to_string(most_cubes_) + " cubes, " +
                         gigabytes(bytes_each() * static_cast<double>(most_cubes_)));
    Octree tree(problem_.mesh);
    std::unique_ptr<const Discretisation> fine;
    for (int level = start_level(tree.edge_mm()); !fine; --level) {
      tree = Octree(problem_.mesh);
      tree.refine_surface(level);
      split_narrow(tree);
      fine = split_everywhere(tree, level == first_level);
    }
    BodyAnswer best;
    while (fine) {
      Answers found = solved(*fine);
      const double worst = estimate(tree, fine->mesh, found, best);
      best.channel = std::move(found.channel);
      best.cubes = fine->mesh.cubes.size();
      best.bridged_area = narrow_.bridged_area(fine->mesh);
      best.iterations = found.iterations;
      best.solved = found.converged;
      best.within_tolerance = worst <= options_.tolerance;
      best.setup_seconds = watch_.seconds() - solving_;
      best.seconds = solving_;
      report(worst, best.cubes);
      std::vector<int> bridging;
      if (best.bridged_area > little_bridged * area_) bridging = narrow_.bridging_cubes(fine->mesh);
      if (best.within_tolerance && bridging.empty()) return best;
      const Indicator indicator = gradient_indicator(*fine, best.channel, weighs_last_);
      std::vector<int> times(indicator.node.size(), 0);
      if (!best.within_tolerance) {
        times = splits(indicator, std::min(most_left, aimed_at * options_.tolerance / worst),
                       most_cubes_);
      }
      split_once_at_least(*fine, bridging, indicator, times);
      fine.reset();
      tree.refine(indicator.node, times);
      fine = split_everywhere(tree, false);
    }
    return best;
  }

 private:
  /// Memory per cube.
  double bytes_each() const {
    return bytes_per_cube + bytes_per_channel * static_cast<double>(channels_.problems.size()) +
           bytes_per_light * static_cast<double>(std::min(channels_.lights(), lights_at_once));
  }

  /// Of the first mesh, before all of its cubes are split.
  int start_level(double edge_mm) const {
    // The shortest that beams enter [mm].
    double mean_free_path = std::numeric_limits<double>::infinity();
    for (const ObjectProblem& problem : channels_.problems) {
      const bool beams = std::any_of(problem.lights.begin(), problem.lights.end(),
                                     [](const ObjectLight& light) { return !light.beams.empty(); });
      const double kappa =
          std::sqrt(problem.medium.smallest().kappa * problem.medium.largest().kappa);
      if (beams) mean_free_path = std::min(mean_free_path, 3.0 * kappa);
    }
    const double h =
        std::max(std::sqrt(cubes_per_square * area_ / static_cast<double>(most_cubes_)),
                 mean_free_path *
                     std::pow(start_excess * options_.tolerance / start_error, 1.0 / start_order));
    const double level = std::ceil(std::log2(edge_mm / h)) - 1.0;
    return static_cast<int>(std::clamp<double>(level, first_level, deepest_level - 1));
  }

  /// Both in Morton order.
  static void split_once_at_least(const Discretisation& d, const std::vector<int>& cubes,
                                  const Indicator& indicator, std::vector<int>& times) {
    std::size_t n = 0;
    for (const int cube : cubes) {
      const int node = d.tree.parent(d.mesh.leaf[static_cast<std::size_t>(cube)]);
      while (indicator.node[n] != node) ++n;
      times[n] = std::max(times[n], 1);
    }
  }

  void split_narrow(Octree& tree) const {
    const CutMesh mesh = cut_mesh(tree, problem_.mesh, problem_.rays);
    std::vector<int> leaves = folds(mesh, problem_.surface);
    const std::vector<int> thin = narrow_.thin_leaves(mesh);
    leaves.insert(leaves.end(), thin.begin(), thin.end());
    std::sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    tree.refine(leaves, std::vector<int>(leaves.size(), narrow_splits));
  }

  Discretisation discretised(Octree tree, CutMesh mesh) const {
    return Discretisation(std::move(tree), std::move(mesh), channels_.media(),
                          channels_.constants.A);
  }

  /// With each of the object's leaves split; none where that is too large, or, where nothing less
  /// can be done, a refusal.
  std::unique_ptr<const Discretisation> split_everywhere(Octree tree, bool least) const {
    tree.refine_each(object_leaves(tree, problem_.mesh, problem_.rays));
    CutMesh mesh = cut_mesh(tree, problem_.mesh, problem_.rays);
    if (mesh.cubes.size() > most_cubes_) {
      if (least) refuse(mesh.cubes.size());
      return nullptr;
    }
    return std::make_unique<const Discretisation>(discretised(std::move(tree), std::move(mesh)));
  }

  Answers solved(const Discretisation& discretisation) {
    const Stopwatch watch;
    Answers result =
        answers(discretisation, channels_,
                *make_linear_solver(discretisation.levels, channels_.lights(), options_.device),
                linear_tolerance(options_.tolerance));
    solving_ += watch.seconds();
    return result;
  }

  /// Fills in the errors of an answer on the tree with every leaf split. The largest relative one.
  double estimate(const Octree& tree, const CutMesh& mesh, const Answers& found, BodyAnswer& best) {
    const std::vector<double> per_difference = narrow_.errors_per_difference(mesh);
    bool apart = false;
    for (std::size_t c = 0; c < found.channel.size(); ++c) {
      for (const std::vector<double>& coarser : found.channel[c].coarser_exitance) {
        apart = apart || coarser.empty() || !homogeneous(c);
      }
    }
    Answers of_tree;
    if (apart) of_tree = solved(discretised(tree, cut_mesh(tree, problem_.mesh, problem_.rays)));
    best.error.assign(found.channel.size(), {});
    double worst = 0.0;
    for (std::size_t c = 0; c < found.channel.size(); ++c) {
      const Answer& fine = found.channel[c];
      for (std::size_t l = 0; l < fine.exitance.size(); ++l) {
        const std::vector<double>* own = apart ? &of_tree.channel[c].exitance[l] : nullptr;
        const double error =
            error_of(c, per_difference, fine.exitance[l], fine.coarser_exitance[l], own);
        best.error[c].push_back(error);
        const double size = surface_norm(problem_.surface, fine.exitance[l]);
        const bool counts = !weighs_last_ || l + 1 < fine.exitance.size();
        if (counts && size > 0.0) worst = std::max(worst, error / size);
      }
    }
    return worst;
  }

  bool homogeneous(std::size_t channel) const {
    return channels_.problems[channel].medium.homogeneous();
  }

  /// By the difference of two resolutions. `coarser` is the tree's answer with the coefficients of
  /// the finer one, empty on small meshes; `own` is that with its own ones, where there is one.
  double error_of(std::size_t channel, const std::vector<double>& per_difference,
                  const std::vector<double>& fine, const std::vector<double>& coarser,
                  const std::vector<double>* own) const {
    const auto difference = [&](const std::vector<double>& one, const std::vector<double>& other) {
      return surface_difference(problem_.surface, one, other);
    };
    const auto resolution = [&](const std::vector<double>& other) {
      std::vector<double> error(fine.size());
      for (std::size_t t = 0; t < fine.size(); ++t) {
        error[t] = per_difference[t] * (fine[t] - other[t]);
      }
      return surface_norm(problem_.surface, error);
    };
    if (homogeneous(channel)) return resolution(coarser.empty() ? *own : coarser);
    // What finer coefficients changed is what they leave: it falls with h where κ jumps.
    const double whole = difference(fine, *own);
    if (coarser.empty()) return whole;
    return std::min(whole, resolution(coarser) + difference(coarser, *own));
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
  const bool weighs_last_;
  Progress& progress_;
  const Stopwatch watch_;
  const NarrowPlaces narrow_{problem_};
  const double area_ =
      std::accumulate(problem_.surface.area.begin(), problem_.surface.area.end(), 0.0);  ///< [mm²]
  double solving_ = 0.0;
  std::size_t most_cubes_ = 0;
};

}  // namespace

BodyAnswer solve_body(std::span<const ObjectProblem> problems, const ObjectOptions& options,
                      bool weighs_last, Progress& progress) {
  return BodySolve(problems, options, weighs_last, progress).run();
}

}  // namespace kappamu::forward::embedded
