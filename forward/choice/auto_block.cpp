#include "forward/choice/auto_block.h"

#include <algorithm>

#include "core/error.h"
#include "forward/choice/choice.h"
#include "forward/diffusion_warnings.h"

namespace kappamu::forward {

namespace {

constexpr const char* grid_diffusion = "grid";

/// Of the two that answer for blocks.
const ModelCandidate& taken(const Choice& choice) {
  return *std::find_if(
      choice.candidates.begin(), choice.candidates.end(),
      [](const ModelCandidate& c) { return c.model == grid_diffusion || c.model == random_walks; });
}

class AutoBlock final : public ForwardModel {
 public:
  ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& options,
                      Progress& progress) const override {
    if (problem.setup.convention != Convention::physical) {
      throw InputError(
          "--method auto compares with transport, in the physical convention; leave out "
          "--convention wang2008 or choose --method multigrid");
    }
    const ObjectFeatures features = features_of(problem.setup, problem.medium);
    ObjectOptions asked;
    asked.tolerance = options.model_tolerance;
    asked.photons = options.photons;
    const Choice choice = choose_model({&features, 1}, asked, {}, Remedy::none);
    const ModelCandidate& model = taken(choice);
    const bool walks = model.model == random_walks;
    ForwardOptions own = options;
    if (walks) own.photons = options_for(random_walks, {&features, 1}, asked).photons;
    ForwardResult result =
        make_forward_model(walks ? random_walks : "multigrid")->solve(problem, own, progress);
    result.message = std::string(walks ? random_walks : "multigrid") + ", " + model.reason + "; " +
                     result.message;
    if (!(model.error.value() <= asked.tolerance)) {
      result.warnings.push_back("no model is expected to answer within --model-tolerance: " +
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
