// What the programs kappamu and kappamu-studies share: options of every command, and failures as one
// sentence and an exit code.
#pragma once

#include "app/command.h"

namespace kappamu::app {

/// main(): parses with the commands that `add` adds, and runs the one asked for.
int run_program(int argc, char** argv, void (*add)(CLI::App&, Globals&));

}  // namespace kappamu::app
