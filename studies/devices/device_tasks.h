// What devices are compared by: one task for every model that has an OpenCL path, at one size each.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device/device_info.h"
#include "studies/subject.h"

namespace kappamu::studies {

/// Where a task is computed: an OpenCL device, or the host without one.
struct Place {
  std::optional<device::DeviceInfo> device;

  /// As options of models take it.
  std::string wanted() const;
  std::string shown() const;
  /// "GPU", "CPU", "other" or "host".
  std::string kind() const;
  bool gpu() const { return device && device->kind == device::Kind::gpu; }
};

/// One task on one device.
struct DeviceAnswer {
  double seconds = 0.0;  ///< by the host's clock until the device has finished, median
  /// What else a new medium or shape costs there, median; none: it is in `seconds`.
  std::optional<double> set_up_seconds = {};
  double count = 0.0;                        ///< of the task's unit, in `seconds`
  std::optional<std::size_t> launches = {};  ///< of kernels, in `seconds`; none: not counted
  std::string size;                          ///< of the problem
  std::string note;                          ///< what differs from the other places
  std::vector<double> values;                ///< that all devices must find
  double allowed = 0.0;  ///< relative 2-norm that two of such values may differ by
};

struct DeviceTask {
  std::string name;
  std::string unit;    ///< of count; empty: seconds alone are stated
  std::string goal;    ///< of a GPU; empty: none
  std::string allows;  ///< why values may differ by so much
  /// Whether the goal is met.
  std::function<bool(const DeviceAnswer&)> meets;
  /// None: there is no such path.
  std::function<std::optional<DeviceAnswer>(const Place&)> measure;
};

struct NamedTask {
  std::string name;
  DeviceTask (*make)(const Request& request);
};
/// In the order they are measured.
const std::vector<NamedTask>& device_tasks();

}  // namespace kappamu::studies
