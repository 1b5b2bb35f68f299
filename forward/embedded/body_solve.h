// One body: an octree refined until two resolutions agree within the tolerance, for every light in
// every medium (colour channel).
#pragma once

#include <span>
#include <string>

#include "core/progress.h"
#include "forward/embedded/discretisation.h"

namespace kappamu::forward::embedded {

/// The answer on the last mesh.
struct BodyAnswer {
  std::vector<Answer> channel;
  /// [channel][light] estimated 2-norm of the exitance's error.
  std::vector<std::vector<double>> error;
  std::size_t cubes = 0;
  int iterations = 0;
  double setup_seconds = 0.0, seconds = 0.0;
  bool within_tolerance = false, solved = true;
  double bridged_area = 0.0;  ///< of the surface, across slits narrower than the last cubes [mm²]
};

/// Problems as ObjectModel::solve_channels takes them, of one body. Throws InputError where its
/// first mesh exceeds what is allowed.
/// `weighs_last`: as of gradient_indicator(); that light's error is no matter.
BodyAnswer solve_body(std::span<const ObjectProblem> problems, const ObjectOptions& options,
                      bool weighs_last, Progress& progress);

}  // namespace kappamu::forward::embedded
