// An OpenCL file as embedded at build time (cmake/EmbedKernels.cmake).
#pragma once

namespace kappamu::device {

struct KernelSource {
  const char* path;  ///< of the .cl file inside the repository
  const char* text;
};

}  // namespace kappamu::device
