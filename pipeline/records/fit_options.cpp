#include "pipeline/records/fit_options.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <type_traits>

#include "core/error.h"
#include "io/json_reason.h"
#include "io/json_whole.h"

namespace kappamu::pipeline {

namespace {

using Json = nlohmann::ordered_json;

/// [W] 4.2.
constexpr double wang2008_lambda = 1e-5;

/// One option's value as JSON.
template <class Value>
Json to_json(const Value& value) {
  return value;
}
Json to_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}
template <class Value, std::size_t n>
Json to_json(const Value& value, const Names<Value, n>& names) {
  return name_of(names, value);
}

Json to_json(const FitStageOptions& options) {
  Json json = Json::object();
  describe(options, [&json](const Option& option, const auto& value, const auto&... names) {
    json[option.name] = to_json(value, names...);
  });
  json["continue_from"] =
      options.continue_from ? Json(options.continue_from->string()) : Json(nullptr);
  return json;
}

/// Takes one option's value out of JSON.
struct Setter {
  const Json& json;

  template <class Value>
  void operator()(const Option& option, Value& value) const {
    const auto found = json.find(option.name);
    if (found == json.end()) return;
    if constexpr (std::is_integral_v<Value> && !std::is_same_v<Value, bool>) {
      value = io::whole<Value>(*found);
    } else {
      found->get_to(value);
    }
  }
  void operator()(const Option& option, std::optional<double>& value) const {
    const auto found = json.find(option.name);
    if (found == json.end()) return;
    value = found->is_null() ? std::nullopt : std::optional(found->get<double>());
  }
  template <class Value, std::size_t n>
  void operator()(const Option& option, Value& value, const Names<Value, n>& names) const {
    const auto found = json.find(option.name);
    if (found == json.end()) return;
    const std::optional<Value> named = value_of(names, found->get<std::string>());
    if (!named) throw InputError(std::string(option.name) + " is not one of " + list_of(names));
    value = *named;
  }
};

/// One row of the page: name, place on the command line, default, unit, requirement, sentence.
struct Row {
  std::string& page;

  template <class Value, class... MoreNames>
  void operator()(const Option& o, const Value& value, const MoreNames&... names) {
    constexpr bool numeric =
        std::is_arithmetic_v<Value> || std::is_same_v<Value, std::optional<double>>;
    std::string allowed;
    if constexpr (numeric) {
      if (std::isfinite(o.bounds.least)) allowed = requirement(o.bounds);
    }
    if constexpr (sizeof...(names) == 1) allowed = (list_of(names), ...);
    const Json json = to_json(value, names...);
    page.append("| ").append(o.name).append(" | ");
    page.append(*o.flag != 0 ? "`" + std::string(o.flag) + "`" : "").append(" | ");
    page.append(json.is_null() ? "none" : json.is_string() ? json.get<std::string>() : json.dump());
    page.append(" | ").append(o.unit).append(" | ").append(allowed).append(" | ");
    page.append(o.text).append(o.shapes_volumes ? " | yes |\n" : " | no |\n");
  }
};

}  // namespace

FitStageOptions usual_options() {
  FitStageOptions options;
  options.fit.uncertainty.probes = inverse::usual_probes;
  options.fit.uncertainty.sensitivity_probes = inverse::usual_probes;
  return options;
}

std::string options_json(const FitStageOptions& options) {
  return to_json(options).dump();
}

std::map<std::string, std::string> options_by_name(const FitStageOptions& options) {
  std::map<std::string, std::string> by_name;
  const Json json = to_json(options);
  for (const auto& [name, value] : json.items()) {
    by_name[name] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return by_name;
}

void set_options(FitStageOptions& options, const std::string& json) {
  try {
    const Json parsed = Json::parse(json);
    describe(options, Setter{parsed});
  } catch (const Json::exception& error) {
    throw InputError(io::json_reason(error));
  }
}

FitStageOptions resolve(FitStageOptions options) {
  inverse::FitOptions& fit = options.fit;
  // As [W] moves, without a metric; every other optimiser has one.
  const bool paper = fit.solver.optimiser.method == inverse::Method::wang2008;
  fit.solver.coordinates = paper ? inverse::Coordinates::voxels : inverse::Coordinates::informed;
  if (fit.regulariser.kind == inverse::RegulariserKind::wang2008 && !fit.path.weight) {
    fit.path.weight = wang2008_lambda;
  }
  inverse::validate(fit);
  return options;
}

std::string options_page() {
  std::string page =
      "# Options of a fit\n\n"
      "Made by `kappamu fit --options-table`. Defaults are those of `kappamu fit` and `kappamu "
      "run`; fit.json and run.json record every option by its name. Options without a place on the "
      "command line are for programs (`inverse/fit/fit_options.h`). Volumes: whether the bits of "
      "kappa and mu depend on it.\n";
  const FitStageOptions options = usual_options();
  for (const char* group : inverse::option_groups) {
    page.append("\n## ").append(group).append(
        "\n\n| name | command line | default | unit | allowed | meaning | volumes |\n"
        "|---|---|---|---|---|---|---|\n");
    describe(options,
             [&page, group](const Option& option, const auto& value, const auto&... names) {
               if (std::string_view(option.group) == group) Row{page}(option, value, names...);
             });
  }
  return page;
}

}  // namespace kappamu::pipeline
