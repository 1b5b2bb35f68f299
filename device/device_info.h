// Which OpenCL devices there are, and which one a user's words select.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace kappamu::device {

enum class Kind { cpu, gpu, other };
std::string to_string(Kind kind);

struct DeviceInfo {
  std::string platform;          ///< "Portable Computing Language"
  std::string platform_version;  ///< "OpenCL 3.0 PoCL 3.1 ..."
  std::string name;
  std::string vendor;
  std::string version;  ///< OpenCL version the device speaks
  std::string driver;
  Kind kind = Kind::other;
  unsigned compute_units = 0;
  std::size_t global_memory_bytes = 0;
  std::size_t max_allocation_bytes = 0;  ///< largest single buffer
  bool fp64 = false;                     ///< computes in double
};

/// All devices of all platforms, in OpenCL's order; empty where no OpenCL driver is installed.
std::vector<DeviceInfo> list_devices();

struct Choice {
  std::size_t index = 0;  ///< into the list
  std::string reason;     ///< one phrase
};

/// "auto" takes the first GPU, else the first CPU, else the first of any kind; other words the
/// first device whose platform or device name contains them (case ignored). Throws InputError in
/// one sentence when none matches or none is installed. "reference" is not a device: callers handle
/// it first.
Choice choose(const std::vector<DeviceInfo>& devices, const std::string& wanted);

}  // namespace kappamu::device
