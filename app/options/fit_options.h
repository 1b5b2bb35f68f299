// The command line's options of the fit that `kappamu fit` and `kappamu run` share.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "app/command.h"
#include "pipeline/records/fit_options.h"

namespace kappamu::app {

/// Adds every option described with a place on the command line, listed by group; `options`
/// outlives the parse.
void add_fit_options(CLI::App& command, pipeline::FitStageOptions& options);
/// Of those keys alone, for a program whose fit takes no others.
void add_fit_options(CLI::App& command, pipeline::FitStageOptions& options,
                     std::span<const std::string_view> keys);

/// An option's place on the command line, by its key: --device.
std::string flag_of(const std::string& key);

/// --device and --seed, where `command` was given them: else what `options` have.
void take_globals(const CLI::App& command, const Globals& globals,
                  pipeline::FitStageOptions& options);

}  // namespace kappamu::app
