// Every OpenCL device beside the processor: time of each task, and whether answers agree.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/numbers/relative_difference.h"
#include "device/context.h"
#include "studies/devices/device_tasks.h"
#include "studies/devices/devices_bench.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

/// Each device that a name chooses, and the host.
std::vector<Place> places_of(const Request& request) {
  std::vector<Place> places;
  const std::vector<device::DeviceInfo> devices = device::list_devices();
  const bool all = request.device == "auto";
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const Place place{devices[i]};
    // Another one of the same name would be the first again.
    const bool own = device::choose(devices, place.wanted()).index == i;
    const bool asked = all || (request.device != "reference" &&
                               device::choose(devices, request.device).index == i);
    if (own && asked) places.push_back(place);
  }
  places.push_back({std::nullopt});
  return places;
}

}  // namespace

std::vector<Json> rows_of_task(const DeviceTask& task, const std::vector<Place>& places) {
  struct Measured {
    Json row;
    std::optional<DeviceAnswer> answer;
    bool processor = false;
  };
  std::vector<Measured> all;
  for (const Place& place : places) {
    Measured one{
        {{"task", task.name}, {"device", place.shown()}, {"kind", place.kind()}}, {}, !place.gpu()};
    try {
      one.answer = task.measure(place);
      if (!one.answer) continue;
    } catch (const InputError& error) {
      one.row["refused"] = error.what();
    } catch (const device::DeviceError& error) {
      one.row["refused"] = error.what();
    }
    all.push_back(std::move(one));
  }
  // What others are held against: the processor's answer, the host's own where there is one.
  const DeviceAnswer *reference = nullptr, *fastest = nullptr;
  for (const Measured& one : all) {
    if (!one.answer || !one.processor) continue;
    reference = &*one.answer;
    if (fastest == nullptr ||
        one.answer->seconds / one.answer->count < fastest->seconds / fastest->count) {
      fastest = &*one.answer;
    }
  }
  std::vector<Json> rows;
  for (Measured& one : all) {
    Json& row = one.row;
    if (one.answer) {
      const DeviceAnswer& answer = *one.answer;
      row["size"] = answer.size;
      row["seconds"] = answer.seconds;
      row["set_up_seconds"] = answer.set_up_seconds ? Json(*answer.set_up_seconds) : Json();
      row["rate"] = answer.count / answer.seconds;
      row["unit"] = task.unit;
      row["launches"] = answer.launches ? Json(*answer.launches) : Json();
      row["note"] = answer.note;
      row["difference"] = row["allowed"] = row["times_processor"] = nullptr;
      bool equal = reference == nullptr || reference == &answer;
      if (!equal) {
        const double difference = relative_difference(answer.values, reference->values);
        const double allowed = 0.5 * (answer.allowed + reference->allowed);
        row["difference"] = difference;
        row["allowed"] = allowed;
        equal = difference <= allowed;
        if (!equal) {
          row["refused"] = "its answer differs from the processor's by more than " + task.allows +
                           "; no ratio of times is stated";
        }
      }
      if (reference == nullptr) {
        row["note"] = "no processor took this task: the answer is not compared";
      } else if (equal) {
        row["times_processor"] = answer.count / answer.seconds * fastest->seconds / fastest->count;
      }
      row["goal"] = task.goal;
      row["goal_met"] = one.processor || !task.meets ? Json() : Json(equal && task.meets(answer));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

namespace {

void measure_devices(const Request& request, Progress& progress, const Save& save) {
  const std::vector<Place> places = places_of(request);
  const std::vector<std::string> asked = request.words("tasks");
  Json rows = Json::array(), devices = Json::array();
  for (const Place& place : places) devices.push_back(place.shown());
  for (const NamedTask& named : device_tasks()) {
    if (!asked.empty() && std::find(asked.begin(), asked.end(), named.name) == asked.end())
      continue;
    progress.update("bench devices",
                    static_cast<double>(&named - device_tasks().data()) /
                        static_cast<double>(device_tasks().size()),
                    named.name);
    for (Json& row : rows_of_task(named.make(request), places)) rows.push_back(std::move(row));
    save({{"devices", devices}, {"rows", rows}});
  }
}

std::vector<std::string> task_names() {
  std::vector<std::string> names;
  for (const NamedTask& task : device_tasks()) names.push_back(task.name);
  return names;
}

}  // namespace

Subject devices_subject() {
  return {
      "devices",
      "Times of every OpenCL device beside the processor's, of equal answers",
      R"(  kappamu-studies devices -o out/bench
  kappamu-studies devices -o out/bench --tasks solve cube --device NVIDIA
  kappamu-studies devices -o out/bench --quick            toy sizes, seconds

Each task runs on every OpenCL device and, where the model has that path, on the host without
OpenCL (the device reference: the block's solver is serial there, objects take all threads).
seconds: by the host's clock until the device has finished, kernels compiled before, median;
set_up_seconds: what a new medium or shape costs besides; launches: of kernels, each of which
takes a GPU's host some 6 µs. times_processor: the rate over that of
the fastest processor of the same run. difference: relative 2-norm from the host's answer, or
from the processor's where the host has none; where it exceeds what the task allows, no ratio is
stated. A device that cannot take a task has its sentence in the row. Goals are those of a GPU.
note, of a fit: seconds that its thread did not wait for the device, how often it waited, kernels
launched, and megabytes copied between them.

Tasks: solve and cube (16 right-hand sides, 256 x 256 x 20 and 256 cubed, to a residual of 1e-6),
fit (one channel; fit-host and fit-device: its vectors on the host or on the device), embedded
(even cubes about a torus), polygrid (1,040,000 nodes, Wang et al. 2008, Table III), hierarchy (the
dipole's, 131,736 triangles, links made anew), montecarlo (photons in a block).

Do not trust it on a machine that does anything else.)",
      {{"devices", "every task", measure_devices}},
      {{"tasks", "Those named; all if absent", Setting::Kind::words, 0, 0, task_names()},
       {"mesh", "Of the polygrid (default scenes/meshes/spot.ply)", Setting::Kind::words},
       {"side", "Voxels along a fit's block (default 64; more than 64: 20 deep, marble's depth)",
        Setting::Kind::number, 8, 256},
       {"repetitions", "Median over these (default 5)", Setting::Kind::number, 1, 100}}};
}

}  // namespace kappamu::studies
