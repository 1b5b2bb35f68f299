// What this machine costs: how much longer than the table's machine every model takes here.
#pragma once

#include <map>
#include <string>

#include "core/mesh/triangle_mesh.h"
#include "core/progress.h"
#include "core/ray_caster.h"
#include "forward/object_model.h"

namespace kappamu::forward {

/// The least of several runs [s].
struct ProbeTime {
  double wall = 0.0;
  double processor = 0.0;  ///< of all threads together
};

/// The probe: a marble cube of 24 mean free paths in parallel light, of 49,152 triangles.
TriangleMesh probe_mesh();

/// Solves the probe by every measured model, `repetitions` times. `rays` is of probe_mesh(). Models
/// that cannot run here are absent.
std::map<std::string, ProbeTime> probe_times(const RayCaster& rays, const std::string& device,
                                             int repetitions, Progress& progress);

/// Wall seconds of the probe over the table's processor seconds: what turns its costs into waiting
/// here.
MachineCosts machine_costs(const std::map<std::string, ProbeTime>& times);

}  // namespace kappamu::forward
