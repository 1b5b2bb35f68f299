#include "render/machine_costs.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/json_reason.h"
#include "io/read_file.h"
#include "render/embree_caster.h"

namespace kappamu::render {

namespace {

using nlohmann::json;

constexpr const char* format = "kappamu-model-costs";
constexpr int repetitions = 3;
/// A factor beyond these is a damaged file, not a machine.
constexpr double smallest_factor = 1e-4, largest_factor = 1e4;

}  // namespace

std::optional<std::filesystem::path> machine_costs_file() {
  std::filesystem::path folder;
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    folder = cache;
  } else if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    folder = std::filesystem::path(home) / ".cache";
  } else {
    return std::nullopt;
  }
  return folder / "kappamu" / "model-costs.json";
}

forward::MachineCosts read_machine_costs(const std::string& device) {
  const std::optional<std::filesystem::path> file = machine_costs_file();
  if (!file || !std::filesystem::exists(*file)) return {};
  try {
    const json record = json::parse(io::read_text(*file));
    if (record.at("format") != format || record.at("version") != 1) {
      throw InputError(file->string() +
                       ": is of another version; measure again with kappamu doctor");
    }
    if (record.at("device") != device) return {};
    auto costs = record.at("costs").get<forward::MachineCosts>();
    for (const auto& [model, cost] : costs) {
      if (!(cost > smallest_factor && cost < largest_factor)) {
        throw InputError(file->string() + ": the cost of " + model +
                         " is out of bounds; remove the file or measure again with kappamu doctor");
      }
    }
    return costs;
  } catch (const json::exception& error) {
    throw InputError(file->string() + ": is damaged (" + io::json_reason(error) +
                     "); remove it or measure again with kappamu doctor");
  }
}

MeasuredCosts measure_machine_costs(const std::string& device, Progress& progress) {
  const std::unique_ptr<RayCaster> rays = make_embree_caster(forward::probe_mesh());
  MeasuredCosts measured;
  measured.times = forward::probe_times(*rays, device, repetitions, progress);
  measured.costs = forward::machine_costs(measured.times);
  if (const std::optional<std::filesystem::path> file = machine_costs_file()) {
    const json record{
        {"format", format}, {"version", 1}, {"device", device}, {"costs", measured.costs}};
    io::write_text_atomically(*file, record.dump(2) + "\n");
  }
  return measured;
}

}  // namespace kappamu::render
