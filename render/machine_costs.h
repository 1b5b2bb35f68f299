// What models of objects cost on this machine, measured once by `kappamu doctor --measure` and kept
// in the user's cache folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "forward/choice/machine_costs.h"

namespace kappamu::render {

/// $XDG_CACHE_HOME/kappamu/model-costs.json, or below $HOME/.cache; none where neither is set.
std::optional<std::filesystem::path> machine_costs_file();

/// Those measured on `device`; empty where none were. Throws InputError where the file is damaged.
forward::MachineCosts read_machine_costs(const std::string& device);

struct MeasuredCosts {
  std::map<std::string, forward::ProbeTime> times;  ///< of the probe
  forward::MachineCosts costs;
};

/// Minutes; leave the machine alone. Writes the file where there is one.
MeasuredCosts measure_machine_costs(const std::string& device, Progress& progress);

}  // namespace kappamu::render
