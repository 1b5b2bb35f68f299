// Which commands there are.
#pragma once

#include "app/command.h"

namespace kappamu::app {

/// Adds all commands, in groups; the help of `app` has one line for each.
void add_commands(CLI::App& app, Globals& globals);

}  // namespace kappamu::app
