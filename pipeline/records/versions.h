// What this program was built with and what it finds on this machine: `kappamu doctor` prints it,
// run.json keeps it.
#pragma once

#include <map>
#include <string>

namespace kappamu::pipeline {

/// Versions by name: kappamu, the compiler, its libraries, and each OpenCL platform with its
/// drivers.
std::map<std::string, std::string> library_versions();

}  // namespace kappamu::pipeline
