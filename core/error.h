// The two kinds of failure: bad input (the user's, told in one sentence) and broken invariants
// (ours).
#pragma once

#include <stdexcept>
#include <string>

namespace kappamu {

/// Bad input. what() is one clear sentence naming the file, the field and the fix.
/// The command line prints it and exits with code 1; libraries never print or exit.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Thrown by a listener (core/progress.h) to stop long work. Whatever was complete on disk stays,
/// and the same call goes on from there.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

/// A promise of our own code that does not hold: a bug, never the user's fault.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws InternalError with `what` unless `holds`.
inline void check(bool holds, const std::string& what) {
  if (!holds) throw InternalError("internal error: " + what);
}

}  // namespace kappamu
