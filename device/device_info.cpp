#include "device/device_info.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "core/error.h"
#include "device/kernel_cache.h"
#include "device/opencl_api.h"

namespace kappamu::device {

namespace {

std::string device_text(cl_device_id device, cl_device_info what) {
  return text_property([&](std::size_t size, void* value, std::size_t* needed) {
    return clGetDeviceInfo(device, what, size, value, needed);
  });
}

std::string platform_text(cl_platform_id platform, cl_platform_info what) {
  return text_property([&](std::size_t size, void* value, std::size_t* needed) {
    return clGetPlatformInfo(platform, what, size, value, needed);
  });
}

template <class T>
T device_value(cl_device_id device, cl_device_info what) {
  T value{};
  check_call(clGetDeviceInfo(device, what, sizeof(T), &value, nullptr), "clGetDeviceInfo",
             device_text(device, CL_DEVICE_NAME));
  return value;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

std::string to_string(Kind kind) {
  switch (kind) {
    case Kind::cpu:
      return "CPU";
    case Kind::gpu:
      return "GPU";
    default:
      return "other";
  }
}

std::vector<PlatformDevice> platform_devices() {
  // PoCL ends the process by an assertion, or shows no device, where it cannot write what it
  // compiled.
  kernel_cache_folder();
  cl_uint count = 0;
  // The loader reports an error, not zero, when no driver is installed.
  if (clGetPlatformIDs(0, nullptr, &count) != CL_SUCCESS || count == 0) return {};
  std::vector<cl_platform_id> platforms(count);
  check_call(clGetPlatformIDs(count, platforms.data(), nullptr), "clGetPlatformIDs", "the loader");
  std::vector<PlatformDevice> all;
  for (cl_platform_id platform : platforms) {
    cl_uint devices = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &devices) != CL_SUCCESS) continue;
    std::vector<cl_device_id> ids(devices);
    check_call(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, devices, ids.data(), nullptr),
               "clGetDeviceIDs", platform_text(platform, CL_PLATFORM_NAME));
    for (cl_device_id id : ids) all.push_back({platform, id});
  }
  return all;
}

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> list;
  for (const auto& [platform, device] : platform_devices()) {
    DeviceInfo info;
    info.platform = platform_text(platform, CL_PLATFORM_NAME);
    info.platform_version = platform_text(platform, CL_PLATFORM_VERSION);
    info.name = device_text(device, CL_DEVICE_NAME);
    info.vendor = device_text(device, CL_DEVICE_VENDOR);
    info.version = device_text(device, CL_DEVICE_VERSION);
    info.driver = device_text(device, CL_DRIVER_VERSION);
    const auto type = device_value<cl_device_type>(device, CL_DEVICE_TYPE);
    info.kind = (type & CL_DEVICE_TYPE_GPU) != 0   ? Kind::gpu
                : (type & CL_DEVICE_TYPE_CPU) != 0 ? Kind::cpu
                                                   : Kind::other;
    info.compute_units = device_value<cl_uint>(device, CL_DEVICE_MAX_COMPUTE_UNITS);
    info.global_memory_bytes = device_value<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE);
    info.max_allocation_bytes = device_value<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
    info.fp64 = device_text(device, CL_DEVICE_EXTENSIONS).find("cl_khr_fp64") != std::string::npos;
    list.push_back(info);
  }
  return list;
}

Choice choose(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
  const std::string advice = "; install pocl-opencl-icd or use the device reference";
  const std::vector<OptionKey> keys{{"device", "reference"}};
  if (devices.empty()) {
    const std::string what =
        wanted == "auto" ? "no OpenCL device was found"
                         : "no OpenCL device matches '" + wanted + "' because none was found";
    throw InputError(what + advice, keys);
  }
  if (wanted == "auto") {
    const auto first = [&](auto wants) {
      return static_cast<std::size_t>(std::find_if(devices.begin(), devices.end(), wants) -
                                      devices.begin());
    };
    const std::size_t gpu = first([](const DeviceInfo& d) { return d.kind == Kind::gpu; });
    if (gpu < devices.size()) return {gpu, "the first GPU"};
    const std::size_t cpu = first([](const DeviceInfo& d) { return d.kind == Kind::cpu; });
    if (cpu < devices.size()) return {cpu, "the first CPU device, as there is no GPU"};
    return {0, "the only kind of device there is"};
  }
  std::string names;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const std::string full = devices[i].platform + " / " + devices[i].name;
    if (lower(full).find(lower(wanted)) != std::string::npos) {
      return {i, "the first whose name contains '" + wanted + "'"};
    }
    names += (i == 0 ? "" : ", ") + full;
  }
  if (wanted == "reference") {
    throw InputError(
        "what is asked for is computed by OpenCL alone, not on the device reference; "
        "leave the device to auto, or choose another model or method",
        {{"device", "auto"}});
  }
  throw InputError("no OpenCL device matches '" + wanted + "' (there is: " + names + ")" + advice,
                   keys);
}

}  // namespace kappamu::device
