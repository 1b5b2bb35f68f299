// The options of the fit stage, and as they are recorded. Each is described once: those of the fit
// in inverse/fit/describe_options.h, those of the stage in describe() below.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "inverse/fit/describe_options.h"

namespace kappamu::pipeline {

struct FitStageOptions {
  inverse::FitOptions fit;
  std::vector<std::string> channels;  ///< names of those to fit; empty = all
  /// Patterns kept out of the fit: "auto", "none", a count or a list
  /// (pipeline/stages/validation_choice.h).
  std::string hold_out = "auto";
  /// Measurements under light of their own to validate the fit by; found beside the input when not
  /// given.
  std::optional<std::filesystem::path> validate;
  bool restart = false;  ///< ignore checkpoints
  /// Folder of a finished fit whose volumes are the start (pipeline/stages/continuation.h).
  std::optional<std::filesystem::path> continue_from;
};

/// The options with what a finished run is reported by: standard deviations and sensitivity. What
/// the commands start from.
FitStageOptions usual_options();

/// Every option that the results depend on, by name: one flat JSON object, equal for equal options.
/// The key of the fit stage, run.json, fit.json and the report are all made of it.
std::string options_json(const FitStageOptions& options);

/// The same by name, each value as JSON writes it.
std::map<std::string, std::string> options_by_name(const FitStageOptions& options);

/// Sets every option that `json`, a text by options_json(), holds, but continue_from. Throws
/// InputError "NAME is not one of ..." or of JSON's own, the end of a sentence.
void set_options(FitStageOptions& options, const std::string& json);

/// What the paper's own methods imply is set, and all bounds are checked. Throws InputError naming
/// option and bound.
FitStageOptions resolve(FitStageOptions options);

/// The page docs/reference/fit-options.md.
std::string options_page();

/// Calls `visit` as inverse::describe() does, then with the stage's own options: hold_out, and
/// channels, a std::vector<std::string>. Where else to validate, --restart and --continue are of
/// the command.
template <class Options, class Visitor>
void describe(Options& options, Visitor&& visit) {
  auto& [fit, channels, hold_out, validate, restart, continue_from] = options;
  inverse::describe(fit, visit);
  visit(Option{"hold_out",
               inverse::option_groups[0],
               "--hold-out",
               "",
               {},
               "Patterns kept out of the fit to validate it by: auto (those captured for "
               "validation, else one of every 16), none, a count, or numbers from 0 with commas "
               "(5,10)"},
        hold_out);
  visit(Option{"channels",
               inverse::option_groups[0],
               "--channel",
               "",
               {},
               "Fit this channel only; may be given several times",
               false},
        channels);
}

}  // namespace kappamu::pipeline
