// What this machine costs: how much longer than the table's machine every model takes here.
#pragma once

#include <map>
#include <string>

#include "core/mesh/triangle_mesh.h"
#include "core/progress.h"
#include "core/ray_caster.h"

namespace kappamu::forward {

/// Seconds here over seconds of the table, by model; a model that is absent counts as 1.
using MachineCosts = std::map<std::string, double>;

/// The probe: a marble cube of 24 mean free paths in parallel light, of few triangles.
TriangleMesh probe_mesh();

/// Solves the probe by every measured model: wall seconds, the best of `repetitions`. `rays` is of
/// probe_mesh(). Models that cannot run here are absent.
MachineCosts probe_seconds(const RayCaster& rays, const std::string& device, int repetitions,
                           Progress& progress);

/// Those seconds over the table's.
MachineCosts machine_costs(const MachineCosts& seconds);

}  // namespace kappamu::forward
