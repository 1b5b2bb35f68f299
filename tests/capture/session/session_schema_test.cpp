// docs/session.schema.json against the reader, on one table of documents. Needs Debian's
// python3-jsonschema.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "tests/capture/session/bad_sessions.h"
#include "tests/capture/session_files.h"
#include "tests/schema_verdicts.h"

namespace kappamu::capture {
namespace {

TEST(SessionSchema, AgreesWithTheReaderOnGoodAndBadDocuments) {
  const OwnFolder folder;
  std::map<std::string, std::string> expected;
  const auto add = [&](const EditedSession& session, bool valid) {
    char stem[8];
    std::snprintf(stem, sizeof stem, "%04zu", expected.size());
    write_text(folder.path() / (std::string(stem) + ".json"), session.text);
    expected[stem] = (valid ? "valid " : "invalid ") + session.name;
  };
  for (const EditedSession& good : good_sessions()) add(good, true);
  for (const BadSession& bad : bad_sessions()) add(bad, !bad.schema_sees_it);
  expect_schema_verdicts("session.schema.json", folder.path(), expected);
}

}  // namespace
}  // namespace kappamu::capture
