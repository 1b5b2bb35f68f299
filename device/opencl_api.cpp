#include "device/opencl_api.h"

#include <algorithm>
#include <sstream>

#include "core/error.h"

namespace kappamu::device {

std::string error_name(cl_int code) {
  switch (code) {
    case CL_DEVICE_NOT_FOUND:
      return "CL_DEVICE_NOT_FOUND";
    case CL_MEM_OBJECT_ALLOCATION_FAILURE:
      return "CL_MEM_OBJECT_ALLOCATION_FAILURE";
    case CL_OUT_OF_RESOURCES:
      return "CL_OUT_OF_RESOURCES";
    case CL_OUT_OF_HOST_MEMORY:
      return "CL_OUT_OF_HOST_MEMORY";
    case CL_BUILD_PROGRAM_FAILURE:
      return "CL_BUILD_PROGRAM_FAILURE";
    case CL_INVALID_VALUE:
      return "CL_INVALID_VALUE";
    case CL_INVALID_KERNEL_NAME:
      return "CL_INVALID_KERNEL_NAME";
    case CL_INVALID_ARG_SIZE:
      return "CL_INVALID_ARG_SIZE";
    case CL_INVALID_ARG_INDEX:
      return "CL_INVALID_ARG_INDEX";
    case CL_INVALID_KERNEL_ARGS:
      return "CL_INVALID_KERNEL_ARGS";
    case CL_INVALID_WORK_GROUP_SIZE:
      return "CL_INVALID_WORK_GROUP_SIZE";
    case CL_INVALID_BUFFER_SIZE:
      return "CL_INVALID_BUFFER_SIZE";
    default:
      return "error " + std::to_string(code);
  }
}

std::string first_error(const std::string& log) {
  constexpr std::size_t longest = 160;
  std::istringstream lines(log);
  std::string found, line;
  while (std::getline(lines, line)) {
    const bool names_error = line.find("error") != std::string::npos;
    if ((found.empty() || names_error) && !line.empty()) found = line.substr(0, longest);
    if (names_error) break;
  }
  std::replace_if(
      found.begin(), found.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return found.empty() ? "the compiler gave no reason" : found;
}

void check_call(cl_int code, const char* call, const std::string& device) {
  if (code == CL_SUCCESS) return;
  if (code == CL_MEM_OBJECT_ALLOCATION_FAILURE || code == CL_OUT_OF_HOST_MEMORY ||
      code == CL_INVALID_BUFFER_SIZE) {
    throw InputError("device '" + device +
                         "' is out of memory; use a coarser grid, fewer patterns at once, or "
                         "another device",
                     {{"device"}});
  }
  throw DeviceError(std::string(call) + " failed with " + error_name(code) + " on device '" +
                    device + "'");
}

}  // namespace kappamu::device
