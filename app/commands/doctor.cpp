#include <sys/sysinfo.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/command.h"
#include "core/error.h"
#include "device/context.h"
#include "device/device_info.h"
#include "forward/grid/solver_self_test.h"
#include "pipeline/records/versions.h"
#include "render/machine_costs.h"

namespace kappamu::app {

namespace {

using Json = nlohmann::ordered_json;

double gib(std::size_t bytes) {
  return static_cast<double>(bytes) / (1024.0 * 1024.0 * 1024.0);
}

struct HostMemory {
  std::size_t total = 0, free = 0;
};
HostMemory host_memory() {
  struct sysinfo info {};
  if (sysinfo(&info) != 0) return {};
  return {static_cast<std::size_t>(info.totalram) * info.mem_unit,
          static_cast<std::size_t>(info.freeram + info.bufferram) * info.mem_unit};
}

struct Examination {
  std::vector<device::DeviceInfo> devices;
  std::optional<device::Choice> choice;
  std::string problem;  ///< why there is no choice
  forward::Verdict verdict;
};

Examination examine(const std::string& wanted) {
  Examination found;
  found.devices = device::list_devices();
  if (wanted == "reference") return found;
  try {
    found.choice = device::choose(found.devices, wanted);
  } catch (const InputError& error) {
    found.problem = error.what();
    return found;
  }
  try {
    found.verdict = forward::device_verdict(device::Context::of(found.choice->index),
                                            forward::Precision::single_precision);
  } catch (const std::exception& error) {
    found.verdict = {false, error.what()};
  }
  return found;
}

Json to_json(const Examination& found, const HostMemory& memory) {
  Json devices = Json::array();
  for (const auto& d : found.devices) {
    devices.push_back({{"platform", d.platform},
                       {"platform_version", d.platform_version},
                       {"name", d.name},
                       {"vendor", d.vendor},
                       {"version", d.version},
                       {"driver", d.driver},
                       {"kind", to_string(d.kind)},
                       {"compute_units", d.compute_units},
                       {"memory_gib", gib(d.global_memory_bytes)},
                       {"max_allocation_gib", gib(d.max_allocation_bytes)},
                       {"double_precision", d.fp64}});
  }
  Json json{{"devices", devices}};
  json["chosen"] = nullptr;
  if (found.choice) {
    json["chosen"] = {{"name", found.devices[found.choice->index].name},
                      {"reason", found.choice->reason},
                      {"self_test_passed", found.verdict.trusted},
                      {"self_test", found.verdict.message}};
  }
  const bool on_device = found.choice && found.verdict.trusted;
  json["solves_on"] = on_device ? found.devices[found.choice->index].name : "reference";
  if (!found.problem.empty()) json["problem"] = found.problem;
  json["host_memory_gib"] = {{"total", gib(memory.total)}, {"free", gib(memory.free)}};
  json["versions"] = pipeline::library_versions();
  return json;
}

void print(const Examination& found, const HostMemory& memory) {
  std::printf("OpenCL devices\n");
  if (found.devices.empty()) std::printf("  none\n");
  for (std::size_t i = 0; i < found.devices.size(); ++i) {
    const device::DeviceInfo& d = found.devices[i];
    std::printf("  %s %s\n      %s, %s, driver %s\n",
                found.choice && found.choice->index == i ? "*" : " ", d.name.c_str(),
                d.platform.c_str(), d.platform_version.c_str(), d.driver.c_str());
    std::printf("      %s, %u compute units, %.1f GiB, largest buffer %.1f GiB, %s\n",
                to_string(d.kind).c_str(), d.compute_units, gib(d.global_memory_bytes),
                gib(d.max_allocation_bytes), d.fp64 ? "double precision" : "no double precision");
  }
  std::printf("\nHost memory\n  %.1f GiB, %.1f free\n", gib(memory.total), gib(memory.free));
  std::printf("\nVersions\n");
  for (const auto& [name, version] : pipeline::library_versions()) {
    std::printf("  %-14s  %s\n", name.c_str(), version.c_str());
  }
  std::printf("\nVerdict\n");
  if (!found.problem.empty()) {
    std::printf("  FAILED: %s\n", found.problem.c_str());
  } else if (!found.choice) {
    std::printf("  solves with the serial reference, as asked; it is slow\n");
  } else {
    const std::string& name = found.devices[found.choice->index].name;
    std::printf("  chosen: %s (%s)\n", name.c_str(), found.choice->reason.c_str());
    if (found.verdict.trusted) {
      std::printf("  known-answer test PASSED: %s\n", found.verdict.message.c_str());
    } else {
      std::printf(
          R"(  KNOWN-ANSWER TEST FAILED: %s
  THIS DEVICE IS NOT USED: commands fall back to the serial reference, which is slow.
  Update its driver, or choose another with --device.
)",
          found.verdict.message.c_str());
    }
  }
}

/// Costs of the models of objects, for `model: auto`.
void measure_costs(const Globals& globals, Json& json) {
  const auto progress = make_progress();
  const render::MeasuredCosts measured = render::measure_machine_costs(globals.device, *progress);
  const auto file = render::machine_costs_file();
  Json models = Json::array();
  for (const auto& [model, time] : measured.times) {
    const auto cost = measured.costs.find(model);
    models.push_back({{"model", model},
                      {"wall_seconds", time.wall},
                      {"processor_seconds", time.processor},
                      {"cost", cost == measured.costs.end() ? Json() : Json(cost->second)}});
  }
  json["model_costs"] = {{"models", models}, {"file", file ? Json(file->string()) : Json()}};
  if (globals.json) return;
  std::printf("\nModels of objects: seconds of a probe, and over processor seconds of the table\n");
  for (const Json& row : models) {
    std::printf("  %-18s  %8.3f s  %s\n", row["model"].get<std::string>().c_str(),
                row["wall_seconds"].get<double>(), row["cost"].dump().c_str());
  }
  std::printf("  %s\n", file ? ("kept in " + file->string()).c_str()
                             : "not kept: neither XDG_CACHE_HOME nor HOME is set");
}

}  // namespace

void add_doctor(CLI::App& app, Globals& globals) {
  auto* command =
      app.add_subcommand("doctor",
                         R"(Examine this machine: OpenCL devices, memory, versions, self-test.

Names the device that is chosen, and why.

  kappamu doctor                    the device `auto` takes
  kappamu doctor --device NVIDIA    the first whose platform or name contains the word

The self-test runs kernels whose answers are known (reductions, prefix sums, a small grid
solve held against the serial reference in double precision). A device that fails is never
used: every command then says so and solves with the reference.
The marked (*) device is the one chosen. --json prints the same as one object.

--measure solves a marble cube by every model of objects, the best of three times, and
keeps what they cost here beside the shipped costs in $XDG_CACHE_HOME/kappamu or
~/.cache/kappamu, by device: "model": {"name": "auto"} of scenes chooses by them.
A minute; leave the machine alone meanwhile.)");
  auto measure = std::make_shared<bool>(false);
  command->add_flag("--measure", *measure, "Measure what models of objects cost on this machine");
  command->footer(
      "Exit codes: 0 all well, 1 no usable device: none matches, or the self-test failed.");
  command->callback([&globals, measure] {
    const Examination found = examine(globals.device);
    const HostMemory memory = host_memory();
    Json json = to_json(found, memory);
    if (!globals.json) print(found, memory);
    if (*measure) measure_costs(globals, json);
    if (globals.json) print_json(json);
    const bool well = globals.device == "reference" || (found.choice && found.verdict.trusted);
    globals.exit_code = well ? 0 : 1;
  });
}

}  // namespace kappamu::app
