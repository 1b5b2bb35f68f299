// Model `embedded`: diffusion in objects of any shape by trilinear elements on cut cubes of an
// octree, [T] chapter 4 with a symmetric discretisation, refined until two resolutions agree within
// the tolerance (docs/embedded.md).
#pragma once

#include "forward/registry.h"

namespace kappamu::forward {

class EmbeddedModel : public ChannelsModel {
 public:
  /// One octree, one set of cut cubes and one hierarchy for all channels, refined until each is
  /// within the tolerance.
  std::vector<ObjectResult> solve_channels(std::span<const ObjectProblem> problems,
                                           const ObjectOptions& options,
                                           Progress& progress) override;
};

ModelDescription embedded_model();

}  // namespace kappamu::forward
