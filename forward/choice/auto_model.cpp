#include "forward/choice/auto_model.h"

#include <algorithm>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/choice/pilot.h"
#include "forward/montecarlo/object_monte_carlo.h"

namespace kappamu::forward {

namespace {

/// Photons of a second walk, where the first was noisier than planned, over those that suffice.
constexpr double walked_on = 1.3;

double worst_error(std::span<const ObjectResult> results) {
  double worst = 0.0;
  for (const ObjectResult& result : results) {
    for (std::size_t l = 0; l < result.error_estimate.size(); ++l) {
      worst = std::max(worst, result.error(l));
    }
  }
  return worst;
}

class AutoModel final : public ChannelsModel {
 public:
  void describe(const OptionVisitor& visit) override {
    visit({"photons", "Monte Carlo", "", "", photons_bounds,
           "Photons per light and channel, the most that random walks may take"},
          &photons_);
  }

  std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                           const ObjectOptions& options,
                                           Progress& progress) override {
    if (problems.empty()) return {};
    const ChoiceOptions asked{options, photons_};
    std::vector<ObjectFeatures> features;
    for (const ObjectProblem& problem : problems) features.push_back(features_of(problem));
    Choice choice = choose_model(choosable_models(), features, asked, Remedy::walks);
    while (true) {
      if (auto pilot = run_pilot(problems, features, asked, choice, progress);
          pilot && pilot->within) {
        for (ObjectResult& result : pilot->results) finish(asked, choice, result);
        return std::move(pilot->results);
      }
      ModelCandidate& first = choice.candidates.front();
      try {
        progress.update("choice of a model", 1.0, first.model + ": " + first.reason);
        const ModelDescription& model = object_model(first.model);
        ChoiceOptions own = options_for(model, features, asked);
        std::vector<ObjectResult> results =
            make_chosen(model, own)->solve_channels(problems, own, progress);
        const double over = worst_error(results) / asked.tolerance;
        if (model.can.transport && over > 1.0 && own.photons < asked.photons) {
          own.photons =
              std::min(asked.photons, static_cast<std::uint64_t>(walked_on * over * over *
                                                                 static_cast<double>(own.photons)));
          results = make_chosen(model, own)->solve_channels(problems, own, progress);
        }
        for (ObjectResult& result : results) finish(asked, choice, result);
        return results;
      } catch (const InputError& refusal) {
        if (!choice.candidates[1].error) throw;
        first = {first.model, {}, {}, 0.0, std::string("refused: ") + refusal.what()};
        rank(choice, asked.tolerance);
      }
    }
  }

 private:
  static void finish(const ObjectOptions& asked, const Choice& choice, ObjectResult& result) {
    result.candidates = choice.candidates;
    const ModelCandidate& taken = choice.candidates.front();
    const bool walks = object_model(taken.model).can.transport;  // their noise is measured
    const double error = std::max(walks ? 0.0 : taken.error.value(), worst_error({&result, 1}));
    if (error <= asked.tolerance) return;
    result.converged = false;
    result.message = formatted("the answer errs by up to %.2g %%, beyond the tolerance of %.2g %%",
                               100.0 * error, 100.0 * asked.tolerance);
    result.warnings.push_back("no model is known to answer within the tolerance; " + taken.model +
                              " comes nearest: " + taken.reason + "; " + result.message);
  }

  std::uint64_t photons_ = ChoiceOptions().photons;
};

}  // namespace

ModelDescription auto_model() {
  return {.name = "auto",
          .text =
              "Takes the cheapest model whose error on such objects, as measured, is within "
              "the tolerance, and corrects it by random walks where it is not.",
          .limits = "Its tolerance is of the whole surface: places may err more.",
          .can = {.heterogeneous = true,
                  .voids = true,
                  .several_bodies = true,
                  .inner_light = true,
                  .reentry = true,
                  .chooses = true},
          .make = [] { return std::make_unique<AutoModel>(); }};
}

}  // namespace kappamu::forward
