// Which light the fit is to see, as options of the commands that show it.
#pragma once

#include <CLI/App.hpp>

#include "capture/rig/shoot.h"

namespace kappamu::app {

/// --bars N or --patches N, into `light`, which must outlive the parse.
void add_fit_light(CLI::App& command, capture::FitLight& light);

}  // namespace kappamu::app
