#include "forward/choice/auto_model.h"

#include <algorithm>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/choice/pilot.h"
#include "forward/object_models.h"

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
        for (ObjectResult& result : pilot->results) finish(asked, choice, result);
        return std::move(pilot->results);
      }
      ModelCandidate& first = choice.candidates.front();
      try {
        progress.update("choice of a model", 1.0, first.model + ": " + first.reason);
        const auto model = make_object_model(first.model, ModelError::stated);
        ObjectOptions options = options_for(first.model, features, asked);
        std::vector<ObjectResult> results = model->solve_channels(problems, options, progress);
        const double over = worst_error(results) / asked.tolerance;
        if (first.model == random_walks && over > 1.0 && options.photons < asked.photons) {
          options.photons = std::min(
              asked.photons, static_cast<std::uint64_t>(walked_on * over * over *
                                                        static_cast<double>(options.photons)));
          results = model->solve_channels(problems, options, progress);
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
    const bool walks = taken.model == random_walks;  // their noise is measured
    const double error = std::max(walks ? 0.0 : taken.error.value(), worst_error({&result, 1}));
    if (error <= asked.tolerance) return;
    result.converged = false;
    result.message = formatted("the answer errs by up to %.2g %%, beyond the tolerance of %.2g %%",
                               100.0 * error, 100.0 * asked.tolerance);
    result.warnings.push_back("no model is known to answer within the tolerance; " + taken.model +
                              " comes nearest: " + taken.reason + "; " + result.message);
  }

  MachineCosts costs_;
};

}  // namespace

std::unique_ptr<ObjectModel> make_auto_model(const MachineCosts& costs) {
  return std::make_unique<AutoModel>(costs);
}

}  // namespace kappamu::forward
