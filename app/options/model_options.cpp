#include "app/options/model_options.h"

#include <CLI/CLI.hpp>
#include <cmath>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/registry.h"

namespace kappamu::app {

namespace {

OptionValue value_in(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  double number = 0.0;
  return CLI::detail::lexical_cast(text, number) ? OptionValue(number) : OptionValue(text);
}

std::string abilities_of(const forward::ModelDescription& model) {
  std::string list;
  for (const std::string& name : forward::names_of(model.can))
    list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "homogeneous boxes" : list;
}

/// Calls `row` with each parameter: name, default, unit, what is allowed, sentence.
template <class Row>
void for_each_parameter(const forward::ModelDescription& model, Row row) {
  model.make()->describe([&](const Option& option, OptionReference reference) {
    const bool bounded = std::isfinite(option.bounds.least);
    row(option, shown_value(value_of(reference)), bounded ? requirement(option.bounds) : "");
  });
}

}  // namespace

OptionValues ModelArguments::values() const {
  OptionValues values;
  for (const std::string& given : parameters) {
    const std::size_t sign = given.find('=');
    if (sign == 0 || sign == std::string::npos)
      throw InputError("'" + given + "' is no parameter of a model; write NAME=VALUE",
                       {{"parameter"}});
    values[given.substr(0, sign)] = value_in(given.substr(sign + 1));
  }
  return values;
}

void add_model_options(CLI::App& command, ModelArguments& arguments, const std::string& text,
                       const std::vector<std::string>& names) {
  command.add_option("--model", arguments.name, text)->check(CLI::IsMember(names));
  command
      .add_option("--parameter", arguments.parameters,
                  "Set a parameter of the model's own; may be given several times")
      ->type_name("NAME=VALUE");
}

std::string models_text() {
  std::string text = "Models, their abilities, limits and own parameters with defaults:\n";
  const std::string indent = "\n                     ";
  for (const forward::ModelDescription& model : forward::object_models()) {
    text += formatted("\n  %-18s ", model.name.c_str()) + model.text + indent +
            "Can: " + abilities_of(model) + "." + indent + model.limits;
    for_each_parameter(
        model, [&](const Option& option, const std::string& usual, const std::string& allowed) {
          text += indent + option.name + " (" + usual + "): " + option.text +
                  (allowed.empty() ? "" : "; " + allowed);
        });
  }
  return text;
}

std::string models_page() {
  std::string page =
      "# Models of objects\n\n"
      "Made by `kappamu render --models-page`. Scenes name a model and its parameters in their "
      "field "
      "`model` ([scene.md](../scene.md)).\n";
  for (const forward::ModelDescription& model : forward::object_models()) {
    page += "\n## " + model.name + "\n\n" + model.text + "\n\n- Abilities: " + abilities_of(model) +
            ".\n- Limits: " + model.limits + "\n";
    bool first = true;
    for_each_parameter(
        model, [&](const Option& option, const std::string& usual, const std::string& allowed) {
          if (std::exchange(first, false))
            page += "\n| parameter | default | unit | allowed | meaning |\n|---|---|---|---|---|\n";
          page += std::string("| `") + option.name + "` | " + usual + " | " + option.unit + " | " +
                  allowed + " | " + option.text + " |\n";
        });
  }
  return page;
}

}  // namespace kappamu::app
