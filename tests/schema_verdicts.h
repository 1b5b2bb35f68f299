#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace kappamu {

/// Every document of `folder` (*.json) held against docs/`schema` by Debian's python3-jsonschema,
/// without which the test is skipped: `expected` maps a file's stem to "valid" or "invalid" and,
/// after a blank, what the document is.
inline void expect_schema_verdicts(const std::string& schema, const std::filesystem::path& folder,
                                   const std::map<std::string, std::string>& expected) {
  constexpr int package_absent = 77;
  const std::string source = KAPPAMU_SOURCE_DIR;
  const std::filesystem::path verdicts = folder / "verdicts.txt";
  const std::string command =
      "/usr/bin/python3 '" + source + "/tests/capture/session/validate_sessions.py' '" + source +
      "/docs/" + schema + "' '" + folder.string() + "' > '" + verdicts.string() + "' 2>&1";
  const int status = std::system(command.c_str());  // NOLINT(bugprone-command-processor): fixed
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == package_absent) GTEST_SKIP() << "python3-jsonschema is not installed";
  ASSERT_EQ(WEXITSTATUS(status), 0);
  std::ifstream lines(verdicts);
  std::size_t seen = 0;
  for (std::string stem, verdict; lines >> stem >> verdict; ++seen) {
    const auto known = expected.find(stem);
    ASSERT_NE(known, expected.end()) << stem;
    EXPECT_EQ(known->second.substr(0, known->second.find(' ')), verdict) << known->second;
  }
  EXPECT_EQ(seen, expected.size());
}

}  // namespace kappamu
