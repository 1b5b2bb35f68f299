// Models of objects on the command line: which, its own parameters, and what help says of all.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/command.h"
#include "core/options/options.h"

namespace kappamu::app {

struct ModelArguments {
  std::optional<std::string> name;
  std::vector<std::string> parameters;  ///< "NAME=VALUE"

  /// Throws InputError where one is no NAME=VALUE.
  OptionValues values() const;
};

/// Adds --model, one of `names`, and --parameter; `arguments` outlives the parse.
void add_model_options(CLI::App& command, ModelArguments& arguments, const std::string& text,
                       const std::vector<std::string>& names);

/// Every model with its sentence, abilities, limits and parameters, for a manual page.
std::string models_text();

/// The page docs/reference/models.md.
std::string models_page();

}  // namespace kappamu::app
