// What model `embedded` costs per cube, phase by phase.
#include <nlohmann/json.hpp>

#include "bench/limits/cut_trial.h"
#include "bench/limits/limits.h"

namespace kappamu::bench {

void limit_object_cost(const Request& request, Progress& progress, const Save& save) {
  const TriangleMesh mesh = trial_mesh("scenes/meshes/nefertiti.ply");
  // Red, green and blue of marble (Jensen et al. 2001).
  const std::vector<ObjectMedium> media{ObjectMedium(Coefficients{0.152, 0.0021}),
                                        ObjectMedium(Coefficients{0.127, 0.0041}),
                                        ObjectMedium(Coefficients{0.111, 0.0071})};
  std::vector<int> levels{6, 7, 8, 9};
  if (request.size == Size::small) levels = {6, 7};
  if (request.size == Size::quick) levels = {4};
  Json rows = Json::array();
  for (const int level : levels) {
    for (const std::string device : {"reference", request.device.c_str()}) {
      progress.update("objects-cost", 0.0, std::to_string(1 << level) + "³, " + device);
      // Kernels are compiled before they are timed.
      if (device != "reference") run_cut_trial(mesh, media, 4, device);
      const CutTrial trial = run_cut_trial(mesh, media, level, device);
      const auto cubes = static_cast<double>(trial.cubes);
      rows.push_back(
          {{"equivalent", std::to_string(1 << level) + "³"},
           {"solver", device},
           {"cubes", trial.cubes},
           {"unknowns", trial.unknowns},
           {"octree [s]", trial.octree.processor},
           {"cuts [s]", trial.cuts.processor},
           {"equations of three channels [s]", trial.equations.processor},
           {"iterations", trial.iterations},
           {"solve of three channels [s]", trial.solve.processor},
           {"wall s per right-hand side", trial.solve.wall / static_cast<double>(media.size())},
           {"µs per cube, all", 1e6 / cubes *
                                    (trial.octree.processor + trial.cuts.processor +
                                     trial.equations.processor + trial.solve.processor)}});
      save({{"rows", rows}});
    }
  }
}

}  // namespace kappamu::bench
