#include "forward/object_validity.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/shown_text.h"
#include "forward/analytic/validity.h"
#include "forward/choice/object_features.h"

namespace kappamu::forward {

namespace {

constexpr double tolerable_error = 0.1;

/// One sentence, or none.
std::optional<std::string> warning_of(const ObjectProblem& problem) {
  const EquivalentSlab slab = equivalent_slab(problem);
  const ValidityEstimate estimate = diffusion_validity(slab.albedo, slab.thickness);
  // What passes a thick slab hardly counts, and its relative error has no bound.
  const double error =
      std::max(std::abs(estimate.reflected.value_or(0.0)), estimate.far_map.value_or(0.0));
  if (error <= tolerable_error) return std::nullopt;
  return formatted(
      "diffusion itself errs by %s %.2g %% in a slab of this albedo (%.2g) and thickness (2V/S, "
      "%.2g mean free paths), which the error estimate does not include; use the model montecarlo "
      "or auto",
      in_validity_table(slab.albedo, slab.thickness) ? "up to" : "at least", 100.0 * error,
      slab.albedo, slab.thickness);
}

class Warned final : public ChannelsModel {
 public:
  explicit Warned(std::unique_ptr<ObjectModel> model) : model_(std::move(model)) {}

  std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                           const ObjectOptions& options,
                                           Progress& progress) override {
    std::vector<ObjectResult> results = model_->solve_channels(problems, options, progress);
    for (std::size_t c = 0; c < results.size(); ++c) {
      if (auto warning = warning_of(problems[c]))
        results[c].warnings.push_back(std::move(*warning));
    }
    return results;
  }

 private:
  std::unique_ptr<ObjectModel> model_;
};

}  // namespace

std::unique_ptr<ObjectModel> warned_of_diffusion(std::unique_ptr<ObjectModel> model) {
  return std::make_unique<Warned>(std::move(model));
}

}  // namespace kappamu::forward
