// The command line's options of the fit that `kappamu fit` and `kappamu run` share.
#pragma once

#include <string>

#include "app/command.h"
#include "pipeline/records/fit_options.h"

namespace kappamu::app {

/// Adds the options to `command`, listed under `group`; `arguments` outlives the parse.
void add_fit_options(CLI::App& command, pipeline::FitArguments& arguments,
                     const std::string& group);

}  // namespace kappamu::app
