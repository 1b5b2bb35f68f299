// One table of good and bad session documents, made by edits of the documented example; used for
// the reader and for the JSON schema, so that the two cannot drift apart.
#pragma once

#include <string>
#include <vector>

namespace kappamu::capture {

struct EditedSession {
  std::string name;  ///< what was done to the example
  std::string text;
};

struct BadSession : EditedSession {
  std::string field;           ///< JSON path the sentence must begin with
  std::string says;            ///< what else it must contain
  bool schema_sees_it = true;  ///< false: a rule across fields, beyond JSON Schema
};

std::vector<EditedSession> good_sessions();
std::vector<BadSession> bad_sessions();

}  // namespace kappamu::capture
