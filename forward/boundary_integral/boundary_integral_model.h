// Model `boundary_integral`: diffusion in homogeneous objects by integral equations on their
// surface, [T] chapter 5, with fast summation, refined until two resolutions agree within the
// tolerance (docs/boundary-integral.md).
#pragma once

#include "forward/registry.h"

namespace kappamu::forward {

class BoundaryIntegralModel : public ObjectModel {
 public:
  ObjectResult solve(const ObjectProblem& problem, const ObjectOptions& options,
                     Progress& progress) override;
};

ModelDescription boundary_integral_model();

}  // namespace kappamu::forward
