// The two kinds of failure: bad input (the user's, told in one sentence) and broken invariants
// (ours).
#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace kappamu {

/// An option by its key, as its description names it (core/options/options.h), and the value
/// advised.
struct OptionKey {
  std::string key, value{};
};

/// Bad input. what() is one clear sentence naming the file, the field and the fix. Where options
/// are part of the fix, options() holds their keys: the program that shows the sentence words them.
/// The command line prints it and exits with code 1; libraries never print or exit.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& sentence, std::vector<OptionKey> options = {})
      : std::runtime_error(sentence), options_(std::move(options)) {}

  const std::vector<OptionKey>& options() const { return options_; }

 private:
  std::vector<OptionKey> options_;
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
