#include "forward/model_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "core/mesh/surface_norm.h"
#include "core/parallel.h"
#include "core/shown_text.h"
#include "forward/choice/error_belief.h"
#include "forward/choice/model_table.h"
#include "forward/registry.h"

namespace kappamu::forward {

namespace {

constexpr double probability = 0.95;
constexpr double tolerable_error = 0.05;
/// Rays from a sample, and the farthest that they look [mean free paths].
constexpr int rays_of_sample = 8;
constexpr double farthest = 5.0;
/// Where diffusion errs, fitted to 24 scenes (docs/objects-bench.md): what the whole surface's
/// closeness counts over that of a place.
constexpr double of_all = 2.0;
/// Of the mean exitance; where less leaves the error grows no more.
constexpr double darkest = 1e-2;

/// How close the opposite surface is: the mean of e^(−distance/mean free path) over directions
/// into the object by the cosine. Near ½ at a sharp edge, 0 where the object is thick and flat.
std::vector<double> closeness(const ObjectProblem& problem, double mean_free_path) {
  const Surface& surface = problem.surface;
  std::vector<double> close(surface.size());
  constexpr std::size_t at_once = 512;
  for_pieces(close.size(), at_once, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d& normal = surface.normal[i];
      const Eigen::Vector3d one = normal.unitOrthogonal(), other = normal.cross(one);
      const double skin = 1e-3 * std::sqrt(surface.area[i]);
      for (int r = 0; r < rays_of_sample; ++r) {
        // Neighbouring samples look along other directions.
        const double turn = std::numbers::phi * static_cast<double>(i * rays_of_sample + r);
        const double angle = 2.0 * std::numbers::pi * (turn - std::floor(turn));
        const double sine = std::sqrt((r + 0.5) / rays_of_sample);
        const Eigen::Vector3d inwards = sine * (std::cos(angle) * one + std::sin(angle) * other) -
                                        std::sqrt(1.0 - sine * sine) * normal;
        const auto hit =
            problem.rays.first_hit(surface.position[i], inwards, skin, farthest * mean_free_path);
        if (hit) close[i] += std::exp(-hit->distance / mean_free_path) / rays_of_sample;
      }
    }
  });
  return close;
}

double mean_of(const Surface& surface, std::span<const double> values) {
  double sum = 0.0, area = 0.0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    sum += surface.area[i] * values[i];
    area += surface.area[i];
  }
  return sum / area;
}

class WithModelError final : public ChannelsModel {
 public:
  WithModelError(std::unique_ptr<ObjectModel> model, const ModelDescription& description,
                 bool warns)
      : model_(std::move(model)), description_(description), warns_(warns) {}

  void describe(const OptionVisitor& visit) override { model_->describe(visit); }

  std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                           const ObjectOptions& options,
                                           Progress& progress) override {
    std::vector<ObjectResult> results = model_->solve_channels(problems, options, progress);
    for (std::size_t c = 0; c < results.size(); ++c) {
      if (description_.errs_by != nullptr) state(problems[c], results[c]);
      if (warns_) warn(options, results[c]);
    }
    return results;
  }

 private:
  void warn(const ObjectOptions& options, ObjectResult& result) const {
    if (description_.errs_by == nullptr) {
      result.warnings.push_back("the error of the model " + description_.name +
                                " against transport was not measured; " + description_.limits);
    }
    // A box of whole voxels is convex.
    if (options.follow_reentry && !description_.can.reentry && description_.can.any_shape) {
      result.warnings.push_back("the model " + description_.name +
                                " does not follow light that leaves the object and meets it again");
    }
  }

  void state(const ObjectProblem& problem, ObjectResult& result) const {
    ObjectFeatures features;
    for (std::size_t l = 0; l < problem.lights.size(); ++l) {
      features = features_of(problem, l);
      const double error = expected_error(description_, features).value();
      const ObjectBalance& balance = result.balance[l];
      result.model_error.push_back(
          std::max(error, balance.entering > 0.0 ? balance.created / balance.entering : 0.0));
    }
    const double worst =
        result.model_error.empty() ? 0.0 : *std::ranges::max_element(result.model_error);
    if (!warns_ || worst <= tolerable_error) return;
    const MeasuredRange range = measured_range();
    const bool beyond =
        features.thickness < range.thinnest || features.albedo < range.lowest_albedo;
    result.warnings.push_back(formatted(
        "the model itself errs by %s %.2g %% against transport on an object of this albedo (%.2g), "
        "thickness (2V/S, %.2g mean free paths) and shape, most at edges, in thin parts and where "
        "little light leaves; use the model montecarlo or auto",
        beyond ? "probably more than" : "up to", 100.0 * worst, features.albedo,
        features.thickness));
  }

  std::unique_ptr<ObjectModel> model_;
  const ModelDescription& description_;
  bool warns_;
};

}  // namespace

std::unique_ptr<ObjectModel> with_model_error(std::unique_ptr<ObjectModel> model,
                                              const ModelDescription& description, bool warns) {
  return std::make_unique<WithModelError>(std::move(model), description, warns);
}

std::optional<double> expected_error(const ModelDescription& description,
                                     const ObjectFeatures& features) {
  if (description.errs_by == nullptr) return std::nullopt;
  const ErrorLaw& law = *description.errs_by;
  return error_quantile({error_by(law, features), law.spread}, probability);
}

std::vector<double> error_map(const ObjectProblem& problem, const ObjectResult& result,
                              std::size_t light) {
  const Surface& surface = problem.surface;
  const std::size_t first = light * surface.size();
  const auto exitance = std::span(result.exitance).subspan(first, surface.size());
  const double mean = mean_of(surface, exitance);
  std::vector<double> map(surface.size(), 0.0);
  if (!(mean > 0.0)) return map;
  const auto leaving = [&](std::size_t i) { return std::max(exitance[i], darkest * mean); };
  if (result.model_error.empty()) {
    for (std::size_t i = 0; i < map.size(); ++i) {
      map[i] = result.standard_error.empty() ? result.error(light)
                                             : result.standard_error[first + i] / leaving(i);
    }
    return map;
  }
  const EquivalentSlab slab = equivalent_slab(problem);
  map = closeness(problem, slab.mean_free_path);
  const double everywhere = of_all * mean_of(surface, map) + 1.0 - slab.albedo;
  std::vector<double> difference(map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    map[i] = (map[i] + everywhere) * std::sqrt(std::max(1.0, mean / leaving(i)));
    difference[i] = map[i] * exitance[i];
  }
  const double scale =
      result.error(light) * surface_norm(surface, exitance) / surface_norm(surface, difference);
  for (double& value : map) value *= scale;
  return map;
}

}  // namespace kappamu::forward
