// Running programs from tests: exit code and both outputs, and a temporary folder per test.
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <string>

#include "tests/own_folder.h"

namespace kappamu {

struct ProcessResult {
  int exit_code = 0;  ///< 128 + signal when killed, as in a shell
  std::string standard_output;
  std::string standard_error;
};

/// Runs a shell command to its end.
ProcessResult run_process(const std::string& shell_command);

/// Before a command of run_process(): a screen of its own. Needs Xvfb.
inline const std::string on_a_screen = KAPPAMU_SOURCE_DIR "/tests/app/with_screen.sh ";

/// How the line begins that tells of kernels being built.
inline constexpr const char* build_notice = "kappamu: building OpenCL kernels";

/// `kappamu arguments`, with the program under test. `environment` goes before it ("A=b C=d"). The
/// line that tells of kernels being built is left out: whether it is there depends on what ran
/// before.
ProcessResult kappamu(const std::string& arguments, const std::string& environment = "");

/// Starts `kappamu arguments` in the background, output discarded; kills it with SIGKILL after
/// `milliseconds` unless it has ended. Returns whether it had to be killed.
bool kappamu_killed_after(const std::string& arguments, int milliseconds);

/// The last line of standard output.
std::string last_line(const std::string& output);

/// Exit code 1 and exactly one line on standard error, "kappamu: ..." with `part` in it.
void expect_one_sentence(const ProcessResult& result, const std::string& part);

class TemporaryFolderTest : public testing::Test {
 protected:
  const std::filesystem::path& folder() const { return folder_; }

 private:
  const OwnFolder folder_;
};

}  // namespace kappamu
