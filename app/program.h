// What the programs kappamu and kappamu-studies share: options of every command, and failures as
// one sentence and an exit code.
#pragma once

#include "app/command.h"

namespace kappamu::app {

/// Of every option of `app` and its commands that is a number: not-a-number and infinity are usage
/// errors. CLI11 takes them, and lets not-a-number through its ranges.
void refuse_non_finite(CLI::App& app);

/// main(): parses with the commands that `add` adds, and runs the one asked for.
int run_program(int argc, char** argv, void (*add)(CLI::App&, Globals&));

}  // namespace kappamu::app
