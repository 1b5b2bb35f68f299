// The OpenCL 1.2 API with its error codes turned into exceptions; for device/*.cpp only.
#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <string>
#include <vector>

namespace kappamu::device {

/// "CL_OUT_OF_RESOURCES", or the number where the code has no name here.
std::string error_name(cl_int code);

/// The line of a compiler's log that names the error, or else the first, without control characters
/// and in at most 160 bytes.
std::string first_error(const std::string& log);

/// Throws DeviceError, or InputError when the device is out of memory, unless `code` is CL_SUCCESS.
void check_call(cl_int code, const char* call, const std::string& device);

/// A text property through one of the clGet...Info functions.
template <class Get>
std::string text_property(Get get) {
  std::size_t size = 0;
  if (get(0, nullptr, &size) != CL_SUCCESS || size == 0) return "";
  std::string text(size, '\0');
  if (get(size, text.data(), nullptr) != CL_SUCCESS) return "";
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text;
}

struct PlatformDevice {
  cl_platform_id platform = nullptr;
  cl_device_id device = nullptr;
};
/// In the order of list_devices().
std::vector<PlatformDevice> platform_devices();

}  // namespace kappamu::device
