// The options between frames and radiance that `kappamu calibrate`, `merge` and `run` share.
#pragma once

#include <map>
#include <string>

#include "app/command.h"
#include "capture/merge.h"

namespace kappamu::app {

/// Adds --response, --merge, --on-flicker and --on-motion to `command`; `options` outlives the
/// parse.
void add_hdr_options(CLI::App& command, capture::HdrOptions& options);

/// The options by name, for run.json.
std::map<std::string, std::string> options_by_name(const capture::HdrOptions& options);

/// The same in one text, equal for equal options: part of the stages' keys.
std::string options_text(const capture::HdrOptions& options);

}  // namespace kappamu::app
