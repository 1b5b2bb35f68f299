// Independent readers: short programs for Debian's Python, which has NumPy, OpenVDB and VTK.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace kappamu::io {

struct ProgramResult {
  int exit_code = 0;
  std::string output;  ///< standard output and standard error
};

inline ProgramResult run_program(const std::string& command) {
  ProgramResult result;
  std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {127, "popen failed"};
  char part[4096];
  while (const std::size_t size = std::fread(part, 1, sizeof part, pipe)) {
    result.output.append(part, size);
  }
  const int status = ::pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return result;
}

inline bool python_has(const std::string& module) {
  return run_program("/usr/bin/python3 -c 'import " + module + "'").exit_code == 0;
}

/// Output of a program text without double quotes, run in `folder`.
inline std::string run_python(const std::string& program, const std::filesystem::path& folder) {
  const ProgramResult result =
      run_program("cd '" + folder.string() + "' && /usr/bin/python3 -c \"" + program + "\"");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  return result.output;
}

/// Output of tests/io/<script> with arguments.
inline std::string run_script(const std::string& script, const std::string& arguments) {
  const ProgramResult result = run_program("/usr/bin/python3 '" + std::string(KAPPAMU_SOURCE_DIR) +
                                           "/tests/io/" + script + "' " + arguments);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  return result.output;
}

}  // namespace kappamu::io

/// Skips the rest of the test where Debian's Python lacks `module`.
#define KAPPAMU_NEED_PYTHON(module)                                                    \
  if (!kappamu::io::python_has(module)) {                                              \
    GTEST_SKIP() << "/usr/bin/python3 has no module " module                           \
                    " (Debian packages python3-numpy, python3-openvdb, python3-vtk9)"; \
  }                                                                                    \
  static_assert(true)
