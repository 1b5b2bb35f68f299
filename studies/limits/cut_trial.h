// One object on an octree split evenly at its surface, solved under light from above.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.h"
#include "core/object_medium.h"

namespace kappamu::studies {

struct CutTrial {
  std::size_t cubes = 0;
  double smallest_fraction = 1.0;  ///< of a cube inside the object, above 0
  int iterations = 0;              ///< to a residual of 1e-6, at most 100
  bool converged = false;
};

/// `level`: surface cubes are the root's edge over 2^level, "64³ equivalent" being 6. One light in
/// every medium. `device`: a solver as ObjectOptions names it.
CutTrial run_cut_trial(const TriangleMesh& mesh, const std::vector<ObjectMedium>& media, int level,
                       const std::string& device);

/// A mesh file, 20 mm long.
TriangleMesh trial_mesh(const std::filesystem::path& file);

}  // namespace kappamu::studies
