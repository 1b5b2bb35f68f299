// What models of objects err by themselves against transport, on the whole and place by place.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "forward/choice/object_features.h"
#include "forward/object_model.h"

namespace kappamu::forward {

/// Whether a model states what it itself errs by, and warns where that is much. `auto` warns
/// otherwise; pictures that move have no time for either.
enum class ModelError { left_out, stated, warned };

struct ModelDescription;

/// A model that fills `model_error` by the description's law, not exceeded with a probability of
/// 0.95. With `warns` it warns of large errors, of those that were not measured and of light that
/// should be followed where it meets the object again and is not.
std::unique_ptr<ObjectModel> with_model_error(std::unique_ptr<ObjectModel> model,
                                              const ModelDescription& description, bool warns);

/// What the model errs by against transport on such an object, not exceeded with a probability of
/// 0.95; none: it does not err, or was not measured.
std::optional<double> expected_error(const ModelDescription& description,
                                     const ObjectFeatures& features);

/// Relative error of every sample of a light's exitance; its 2-norm over the surface is
/// `result.error(light)`. Of a model of diffusion it is larger at edges, in thin parts and where
/// little light leaves (docs/objects-bench.md); of random walks it is a sample's standard error.
std::vector<double> error_map(const ObjectProblem& problem, const ObjectResult& result,
                              std::size_t light);

}  // namespace kappamu::forward
