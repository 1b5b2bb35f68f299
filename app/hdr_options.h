// The command line's options between frames and radiance that `kappamu calibrate`, `merge` and
// `run` share.
#pragma once

#include "app/command.h"
#include "capture/radiance/merge.h"

namespace kappamu::app {

/// Adds --on-flicker and --on-motion to `command`; `options` outlives the parse.
void add_hdr_options(CLI::App& command, capture::MergeOptions& options);

}  // namespace kappamu::app
