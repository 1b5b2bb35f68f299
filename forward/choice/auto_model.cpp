#include "forward/choice/auto_model.h"

#include "core/error.h"
#include "forward/choice/pilot.h"
#include "forward/object_models.h"
#include "forward/object_validity.h"

namespace kappamu::forward {

namespace {

class AutoModel final : public ChannelsModel {
 public:
  explicit AutoModel(MachineCosts costs) : costs_(std::move(costs)) {}

  std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                           const ObjectOptions& asked,
                                           Progress& progress) override {
    if (problems.empty()) return {};
    std::vector<ObjectFeatures> features;
    for (const ObjectProblem& problem : problems) features.push_back(features_of(problem));
    Choice choice = choose_model(features, asked, costs_, Remedy::walks);
    while (true) {
      if (auto pilot = run_pilot(problems, features, asked, choice, progress);
          pilot && pilot->within) {
        finish(problems, asked, choice, pilot->results);
        return std::move(pilot->results);
      }
      ModelCandidate& first = choice.candidates.front();
      try {
        progress.update("choice of a model", 1.0, first.model + ": " + first.reason);
        std::vector<ObjectResult> results =
            make_object_model(first.model)
                ->solve_channels(problems, options_for(first.model, features, asked), progress);
        finish(problems, asked, choice, results);
        return results;
      } catch (const InputError& refusal) {
        if (!choice.candidates[1].error) throw;
        first = {first.model, {}, {}, 0.0, std::string("refused: ") + refusal.what()};
        rank(choice, asked.tolerance);
      }
    }
  }

 private:
  static void finish(std::span<const ObjectProblem> problems, const ObjectOptions& asked,
                     const Choice& choice, std::vector<ObjectResult>& results) {
    for (std::size_t c = 0; c < results.size(); ++c) {
      ObjectResult& result = results[c];
      result.candidates = choice.candidates;
      // Diffusion's error is part of what the choice states.
      if (const auto warning = object_validity_warning(problems[c]))
        std::erase(result.warnings, *warning);
      const ModelCandidate& taken = choice.candidates.front();
      if (taken.error.value() <= asked.tolerance) continue;
      result.warnings.push_back("no model is expected to answer within the tolerance; " +
                                taken.model + " comes nearest: " + taken.reason);
    }
  }

  MachineCosts costs_;
};

}  // namespace

std::unique_ptr<ObjectModel> make_auto_model(const MachineCosts& costs) {
  return std::make_unique<AutoModel>(costs);
}

}  // namespace kappamu::forward
