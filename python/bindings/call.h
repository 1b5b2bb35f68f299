// The commands for other programs: described, and called by name with options by key.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "app/command.h"

namespace kappamu::python {

/// Every command in the order of the help: [{name, group, text, footer, options}]. An option is
/// {key, flag, text, default, type, group, required, positional, kind, least, most}: `key` is the
/// name by which programs give it (the one in records where the option is a fit's, else the flag's
/// with underscores); `flag` is its place on the command line; `kind` is "value", "on" (a flag that
/// sets it) or "off" (a flag that clears it); a value is `least` to `most` words.
nlohmann::ordered_json describe_commands();

/// The words given for each key; of a flag none.
using CommandValues = std::map<std::string, std::vector<std::string>>;

/// Runs the command in this process; its result and progress go to `caller`. Returns the exit code:
/// 0, or what the command leaves without an exception. Throws InputError for a command or key that
/// does not exist and for values that the command line would refuse.
int call_command(const std::string& command, const CommandValues& values, app::Caller& caller);

}  // namespace kappamu::python
