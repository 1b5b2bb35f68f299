#include "forward/choice/auto_block.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "forward/choice/choice.h"
#include "forward/diffusion_warnings.h"

namespace kappamu::forward {

namespace {

/// The two that answer for blocks, by their names as methods.
constexpr const char *diffusion = "multigrid", *transport = "montecarlo";

class AutoBlock final : public ForwardModel {
 public:
  ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& options,
                      Progress& progress) const override {
    if (problem.setup.convention != Convention::physical) {
      throw InputError(
          "method auto compares with transport, in the physical convention; use that convention or "
          "the method multigrid",
          {{"convention", "physical"}, {"method", "multigrid"}});
    }
    const ObjectFeatures features = features_of(problem.setup, problem.medium);
    ChoiceOptions asked;
    asked.tolerance = options.model_tolerance;
    asked.photons = options.photons;
    const std::array models{&object_model("grid"), &transport_model()};
    const Choice choice = choose_model(models, {&features, 1}, asked, Remedy::none);
    const ModelCandidate& model = choice.candidates.front();
    const bool walks = model.model == transport_model().name;
    ForwardOptions own = options;
    if (walks) own.photons = options_for(transport_model(), {&features, 1}, asked).photons;
    const std::string method = walks ? transport : diffusion;
    ForwardResult result = make_forward_model(method)->solve(problem, own, progress);
    result.message = method + ", " + model.reason + "; " + result.message;
    if (!(model.error.value() <= asked.tolerance)) {
      result.warnings.push_back(
          "no model is expected to answer within the tolerance asked of the model: " +
          result.message);
    }
    if (!walks) {
      for (std::string& warning :
           diffusion_warnings(problem.setup, problem.medium, options.precision))
        result.warnings.push_back(std::move(warning));
    }
    return result;
  }
};

}  // namespace

ObjectFeatures features_of(const GridSetup& setup, const Medium& medium) {
  double extinction = 0.0, mu = 0.0;
  for (std::size_t i = 0; i < medium.kappa.size(); ++i) {
    extinction += 1.0 / (3.0 * medium.kappa[i]);
    mu += medium.mu[i];
  }
  const auto count = static_cast<double>(medium.kappa.size());
  const double mean_free_path = count / extinction, h = setup.shape.voxel_mm;
  const double x = setup.shape.nx * h, y = setup.shape.ny * h, z = setup.shape.nz * h;
  const double surface = 2.0 * (x * y + y * z + z * x), longest = std::max({x, y, z});
  const auto [least_kappa, most_kappa] =
      std::minmax_element(medium.kappa.values().begin(), medium.kappa.values().end());
  const auto [least_mu, most_mu] =
      std::minmax_element(medium.mu.values().begin(), medium.mu.values().end());
  const double hardly_absorbs = 1e-3 / (3.0 * *most_kappa);
  ObjectFeatures features;
  features.size = longest / mean_free_path;
  features.albedo = 1.0 - mu / count * mean_free_path;
  features.contrast = std::max(*most_kappa / *least_kappa, std::max(*most_mu, hardly_absorbs) /
                                                               std::max(*least_mu, hardly_absorbs));
  features.block = true;
  features.diffuse = setup.source == SourceModel::first_collision ? 0.0 : 1.0;
  for (const Face face : all_faces) features.triangles += face_shape(setup.shape, face).cells();
  features.patches = features.triangles;  // its answer is given per pixel
  if (setup.sides == Sides::mirror) {
    features.thickness = setup.thickness_mm() / mean_free_path;
  } else {
    features.thickness = 2.0 * x * y * z / surface / mean_free_path;
    features.edges = std::min(4.0 * (x + y + z) * mean_free_path / surface, 3.0 / features.size);
  }
  return features;
}

std::unique_ptr<ForwardModel> make_auto_block_model() {
  return std::make_unique<AutoBlock>();
}

}  // namespace kappamu::forward
