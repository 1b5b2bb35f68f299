// A whole simulated capture: a session folder such as any rig leaves, and its ground truth beside
// it, apart.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "capture/rig/shoot.h"
#include "core/grid.h"
#include "core/progress.h"
#include "data_synthetic/rig/simulated_rig.h"
#include "data_synthetic/simulation_options.h"

namespace kappamu::synthetic {

struct SimulationReport {
  std::filesystem::path session;  ///< folder with session.json
  std::filesystem::path truth;    ///< folder with truth.json (data_synthetic/truth.h)
  std::string sample;
  GridShape grid;               ///< to be fitted
  GridShape transport_grid;     ///< light was computed here
  std::string transport_model;  ///< the physics, in a few words
  std::string transport_backend;
  int patterns = 0;
  int frames = 0;
  std::map<std::string, double> seconds;  ///< "transport", "shooting", "truth"
};

/// Writes out/session and out/truth. `device` computes the light transport ("auto", "reference", or
/// part of an OpenCL device's name). The same options give the same session on one device. Throws
/// InputError for options out of range and when out/session exists already.
SimulationReport simulate(const SimulationOptions& options, const std::filesystem::path& out,
                          const std::string& device, Progress& progress);

/// The patterns of a session: those to fit and those that validate.
std::vector<capture::PlannedPattern> planned_patterns(const Rig& rig,
                                                      const SimulationOptions& options);

/// What the operator plans to shoot with a rig whose gain is set.
capture::CapturePlan capture_plan(const SimulatedRig& rig, const SimulationOptions& options,
                                  std::vector<capture::PlannedPattern> patterns);

}  // namespace kappamu::synthetic
