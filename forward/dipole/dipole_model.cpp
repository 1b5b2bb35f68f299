#include "forward/dipole/dipole_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "forward/dipole/assumptions.h"
#include "forward/dipole/direct/direct_sum.h"
#include "forward/dipole/hierarchy/hierarchy.h"
#include "forward/dipole/local/local_diffusion.h"
#include "forward/dipole/relight.h"
#include "forward/dipole/sum_check.h"
#include "forward/dipole/transmitted.h"
#include "forward/light_entry.h"

namespace kappamu::forward {

namespace {

using namespace dipole;

/// Times that the hierarchy's opening is narrowed until the tolerance is met.
constexpr int most_attempts = 4;
/// Beyond this many triangles the direct sum takes minutes.
constexpr std::size_t most_direct_triangles = 40'000;

void require(bool holds, const std::string& sentence) {
  if (!holds) throw InputError(sentence);
}

void validate(const ObjectProblem& problem, const ObjectOptions& options) {
  check_problem(problem, options);
  require(problem.medium.homogeneous(),
          "the dipole answers for a homogeneous medium alone; use the model embedded");
  require(!options.max_elements || problem.surface.size() <= *options.max_elements,
          "the mesh has " + std::to_string(problem.surface.size()) + " triangles but " +
              std::to_string(options.max_elements.value_or(0)) +
              " are allowed; raise max_elements or simplify the mesh");
}

/// Over all pairs of triangles with sources along the normal; the others with rotated ones.
enum class Summation { direct, hierarchy, local };

class DipoleModel : public ObjectModel {
 public:
  DipoleModel(std::string profile, Summation summation)
      : profile_(std::move(profile)), summation_(summation) {}

  std::unique_ptr<LiveModel> keep(const LiveBody& object, const ObjectOptions& options,
                                  Progress& /*progress*/) override {
    if (summation_ != Summation::hierarchy || profile_ != "dipole") return nullptr;
    return make_relight(object, options);
  }

  ObjectResult solve(const ObjectProblem& problem, const ObjectOptions& options,
                     Progress& progress) override {
    validate(problem, options);
    const Coefficients c = problem.medium.smallest();
    const Profile profile = make_profile(profile_, {c.kappa, c.mu}, problem.eta);
    std::vector<std::vector<double>> irradiance;
    for (const ObjectLight& light : problem.lights)
      irradiance.push_back(transmitted(problem.surface, problem.eta, light));
    ObjectResult result;
    result.elements = problem.surface.size();
    if (summation_ == Summation::direct) {
      sum_directly(problem, options, profile, irradiance, progress, result);
    } else if (summation_ == Summation::local) {
      sum_locally(problem, options, profile, irradiance, progress, result);
    } else {
      sum_by_hierarchy(problem, options, profile, irradiance, progress, result);
    }
    add_balance(problem, options, irradiance, result);
    for (std::string& warning : assumption_warnings(problem)) {
      result.warnings.push_back(std::move(warning));
    }
    return result;
  }

 private:
  void sum_directly(const ObjectProblem& problem, const ObjectOptions& options,
                    const Profile& profile, const std::vector<std::vector<double>>& irradiance,
                    Progress& progress, ObjectResult& result) const {
    const std::size_t samples = problem.surface.size();
    require(options.max_elements || samples <= most_direct_triangles,
            "sources along the normal are summed over all pairs of triangles, and " +
                std::to_string(samples) +
                " triangles take long; use dipole-rotated or set "
                "max_elements");
    const Stopwatch watch;
    std::vector<std::size_t> all(samples);
    std::iota(all.begin(), all.end(), 0);
    for (std::size_t l = 0; l < irradiance.size(); ++l) {
      progress.update("dipole", static_cast<double>(l) / static_cast<double>(irradiance.size()),
                      "");
      const std::vector<double> exitance = direct_sum(problem.mesh, problem.surface, profile,
                                                      Placement::aligned, irradiance[l], all);
      result.exitance.insert(result.exitance.end(), exitance.begin(), exitance.end());
    }
    result.error_estimate.assign(irradiance.size(), 0.0);
    result.seconds = watch.seconds();
    result.converged = true;
    result.message = "all pairs of triangles were summed";
    if (auto warning = aligned_source_warning(problem)) result.warnings.push_back(*warning);
  }

  void sum_by_hierarchy(const ObjectProblem& problem, const ObjectOptions& options,
                        const Profile& profile, const std::vector<std::vector<double>>& irradiance,
                        Progress& progress, ObjectResult& result) const {
    const std::size_t samples = problem.surface.size(), lights = irradiance.size();
    const Stopwatch watch;
    const SumCheck check(problem.mesh, problem.surface, problem.surface.area, options.seed);
    std::vector<std::vector<double>> exact;
    for (const std::vector<double>& light : irradiance) {
      exact.push_back(check.exact(profile, Placement::rotated, light));
    }
    HierarchyOptions hierarchy_options;
    Hierarchy hierarchy(device::Context::chosen(options.device), problem.mesh,
                        std::span(&profile, 1), hierarchy_options);
    double worst = 0.0;
    for (int attempt = 1;; ++attempt) {
      const Stopwatch solving;
      result.exitance.assign(lights * samples, 0.0);
      for (std::size_t first = 0; first < lights; first += lanes) {
        solve_lanes(hierarchy, irradiance, first, result.exitance);
      }
      result.seconds = solving.seconds();
      worst = 0.0;
      result.error_estimate.clear();
      for (std::size_t l = 0; l < lights; ++l) {
        result.error_estimate.push_back(
            check.error(exact[l], std::span(result.exitance).subspan(l * samples, samples)));
        worst = std::max(worst, result.error_estimate.back());
      }
      result.iterations = attempt;
      result.converged = worst <= options.tolerance;
      progress.update("dipole", 1.0, std::to_string(hierarchy.links()) + " links");
      if (result.converged || attempt == most_attempts) break;
      // The error falls with the third power of the opening.
      hierarchy_options.opening *=
          0.9F * static_cast<float>(std::max(0.3, std::cbrt(options.tolerance / worst)));
      hierarchy.set_opening(hierarchy_options.opening);
    }
    result.setup_seconds = watch.seconds() - result.seconds;
    result.message =
        formatted("%zu links; their error, measured at %zu triangles, is %g%s", hierarchy.links(),
                  check.triangles(), worst, result.converged ? "" : ", above the tolerance");
    if (!result.converged) result.warnings.push_back(result.message);
  }

  /// Up to four lights from `first` on.
  static void solve_lanes(Hierarchy& hierarchy, const std::vector<std::vector<double>>& irradiance,
                          std::size_t first, std::vector<double>& exitance) {
    const std::size_t samples = irradiance[first].size();
    const std::size_t used = std::min(lanes, irradiance.size() - first);
    std::vector<Eigen::Array4f> in(samples, Eigen::Array4f::Zero());
    for (std::size_t lane = 0; lane < used; ++lane) {
      for (std::size_t t = 0; t < samples; ++t) {
        in[t][static_cast<Eigen::Index>(lane)] = static_cast<float>(irradiance[first + lane][t]);
      }
    }
    const std::vector<Eigen::Array4f> out = hierarchy.exitance(in);
    for (std::size_t lane = 0; lane < used; ++lane) {
      for (std::size_t t = 0; t < samples; ++t) {
        exitance[(first + lane) * samples + t] =
            static_cast<double>(out[t][static_cast<Eigen::Index>(lane)]);
      }
    }
  }

  static void add_balance(const ObjectProblem& problem, const ObjectOptions& options,
                          const std::vector<std::vector<double>>& irradiance,
                          ObjectResult& result) {
    const std::size_t samples = problem.surface.size();
    double worst = 0.0;
    for (std::size_t l = 0; l < irradiance.size(); ++l) {
      ObjectBalance balance;
      for (std::size_t t = 0; t < samples; ++t) {
        balance.entering += problem.surface.area[t] * irradiance[l][t];
        balance.exiting += problem.surface.area[t] * result.exitance[l * samples + t];
      }
      balance.absorbed = std::max(0.0, balance.entering - balance.exiting);
      balance.created = std::max(0.0, balance.exiting - balance.entering);
      if (balance.entering > 0.0) worst = std::max(worst, balance.created / balance.entering);
      result.balance.push_back(balance);
    }
    if (worst > options.tolerance) {
      const std::string sentence = formatted(
          "the dipole lets %.3g times the entering power leave: the object is too thin for the "
          "half-space it assumes; use the model embedded or montecarlo",
          1.0 + worst);
      result.converged = false;
      result.message += "; " + sentence;
      result.warnings.push_back(sentence);
    }
  }

  std::string profile_;
  Summation summation_;
};

/// `law`: the measured model whose physics it has.
ModelDescription half_space(const char* name, const char* text, const char* profile,
                            Summation summation, const char* law) {
  return {
      .name = name,
      .text = text,
      .limits =
          "Only homogeneous objects, as if each place were a thick half-space: errs by 10 "
          "to 40 %, more where the object is thin.",
      .can = {},
      .make = [profile, summation] { return std::make_unique<DipoleModel>(profile, summation); },
      .errs_by = &measured(law).error};
}

}  // namespace

ModelDescription dipole_model() {
  return half_space("dipole", "The classical dipole, over all pairs of triangles.", "dipole",
                    Summation::direct, "dipole-rotated");
}

ModelDescription rotated_dipole_model() {
  ModelDescription model =
      half_space("dipole-rotated", "The dipole with reciprocal sources, summed by a hierarchy.",
                 "dipole", Summation::hierarchy, "dipole-rotated");
  model.measured = &measured("dipole-rotated");
  model.can.live = true;
  return model;
}

ModelDescription local_diffusion_model() {
  return half_space("local-diffusion",
                    "The dipole with reciprocal sources, by samples about what the camera sees.",
                    "dipole", Summation::local, "dipole-rotated");
}

ModelDescription better_dipole_model() {
  ModelDescription model = half_space("better-dipole", "The better dipole, summed by a hierarchy.",
                                      "better-dipole", Summation::hierarchy, "better-dipole");
  model.measured = &measured("better-dipole");
  return model;
}

ModelDescription beam_diffusion_model() {
  return half_space("beam-diffusion", "Photon beam diffusion, summed by a hierarchy.",
                    "beam-diffusion", Summation::hierarchy, "better-dipole");
}

}  // namespace kappamu::forward
