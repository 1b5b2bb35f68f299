#include "pipeline/records/versions.h"

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "device/device_info.h"

#if __has_include(<opencv4/opencv2/core/version.hpp>)
#include <opencv4/opencv2/core/version.hpp>
#endif
#if __has_include(<openvdb/version.h>)
#include <openvdb/version.h>
#endif
#if __has_include(<OpenImageIO/oiioversion.h>)
#include <OpenImageIO/oiioversion.h>
#endif
#if __has_include(<ceres/version.h>)
#include <ceres/version.h>
#endif

namespace kappamu::pipeline {

std::map<std::string, std::string> library_versions() {
  const auto dotted = [](int a, int b, int c) {
    return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
  };
  std::map<std::string, std::string> versions{
      {"kappamu", "0.1.0"},
      {"Eigen", dotted(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"nlohmann-json", dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                               NLOHMANN_JSON_VERSION_PATCH)}};
#if defined(__VERSION__)
  versions["compiler"] = __VERSION__;
#endif
#ifdef CV_VERSION
  versions["OpenCV"] = CV_VERSION;
#endif
#ifdef OPENVDB_LIBRARY_VERSION_STRING
  versions["OpenVDB"] = OPENVDB_LIBRARY_VERSION_STRING;
#endif
#ifdef OIIO_VERSION_STRING
  versions["OpenImageIO"] = OIIO_VERSION_STRING;
#endif
#ifdef CERES_VERSION_STRING
  versions["Ceres"] = CERES_VERSION_STRING;
#endif
  try {
    for (const device::DeviceInfo& d : device::list_devices()) {
      versions["OpenCL platform " + d.platform] = d.platform_version;
      versions["OpenCL driver of " + d.name] = d.driver;
    }
  } catch (const InputError&) {
    // OpenCL cannot be used: whoever needs a device is refused with the reason, nobody else.
  }
  return versions;
}

}  // namespace kappamu::pipeline
