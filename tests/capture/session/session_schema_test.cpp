// docs/session.schema.json against the reader, on one table of documents. Needs Debian's
// python3-jsonschema.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>

#include "tests/capture/session/bad_sessions.h"
#include "tests/capture/session_files.h"

namespace kappamu::capture {
namespace {

constexpr int package_absent = 77;

TEST(SessionSchema, AgreesWithTheReaderOnGoodAndBadDocuments) {
  const TemporaryFolder folder;
  std::map<std::string, std::string> expected;
  std::map<std::string, std::string> names;
  const auto add = [&](const EditedSession& session, bool valid) {
    char stem[8];
    std::snprintf(stem, sizeof stem, "%04zu", expected.size());
    write_text(folder.path() / (std::string(stem) + ".json"), session.text);
    expected[stem] = valid ? "valid" : "invalid";
    names[stem] = session.name;
  };
  for (const EditedSession& good : good_sessions()) add(good, true);
  for (const BadSession& bad : bad_sessions()) add(bad, !bad.schema_sees_it);

  const std::string source = KAPPAMU_SOURCE_DIR;
  const std::filesystem::path verdicts = folder.path() / "verdicts.txt";
  const std::string command = "/usr/bin/python3 '" + source +
                              "/tests/capture/session/validate_sessions.py' '" + source +
                              "/docs/session.schema.json' '" + folder.path().string() + "' > '" +
                              verdicts.string() + "' 2>&1";
  const int status = std::system(command.c_str());  // NOLINT(bugprone-command-processor): fixed
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == package_absent) GTEST_SKIP() << "python3-jsonschema is not installed";
  ASSERT_EQ(WEXITSTATUS(status), 0) << read_text(verdicts);

  std::istringstream lines(read_text(verdicts));
  std::map<std::string, std::string> got;
  for (std::string stem, verdict; lines >> stem >> verdict;) got[stem] = verdict;
  ASSERT_EQ(got.size(), expected.size());
  for (const auto& [stem, verdict] : expected) EXPECT_EQ(got[stem], verdict) << names[stem];
}

}  // namespace
}  // namespace kappamu::capture
