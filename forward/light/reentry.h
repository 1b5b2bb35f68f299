// Light that leaves the object and meets it again: what leaves a triangle is taken as spread by the
// cosine, what arrives as diffuse irradiance.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/progress.h"
#include "forward/object_model.h"

namespace kappamu::forward {

/// Which triangle each triangle sees along fixed directions.
class SeenTriangles {
 public:
  SeenTriangles(const ObjectProblem& problem, std::size_t rays_per_triangle);
  /// What arrives on every triangle of light that leaves them: irradiance from exitance.
  std::vector<double> irradiance(const std::vector<double>& exitance) const;

 private:
  std::size_t rays_;
  std::vector<int> seen_;  ///< [triangle][ray]; −1: none
};

/// Answers of a model that does not follow light outside.
using SolveOnce = std::function<std::vector<ObjectResult>(std::span<const ObjectProblem> problems,
                                                          const ObjectOptions& options)>;

/// The answers of `once`, with the light that meets the object again counted, and, where
/// options.follow_reentry asks for it, sent in again until what is left is a tenth of the
/// tolerance.
std::vector<ObjectResult> with_reentry(std::span<const ObjectProblem> problems,
                                       const ObjectOptions& options, const SolveOnce& once);

}  // namespace kappamu::forward
