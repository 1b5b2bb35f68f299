#include "pipeline/stages/validation_choice.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "core/error.h"
#include "inverse/validation/validation_patterns.h"

namespace kappamu::pipeline {

namespace {

[[noreturn]] void refuse(const std::string& choice, const std::string& why) {
  throw InputError("the patterns to hold out, '" + choice + "', are wrong: " + why, {{"hold_out"}});
}

int number(const std::string& choice, std::string_view text) {
  int value = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value);
  if (text.empty() || parsed.ec != std::errc() || parsed.ptr != end || value < 0) {
    refuse(choice, "give auto, none, a count, or pattern numbers with commas such as 5,10");
  }
  return value;
}

std::vector<int> listed(const std::string& choice, int patterns) {
  std::vector<int> list;
  std::string_view rest = choice;
  while (!rest.empty()) {
    const std::size_t comma = rest.find(',');
    list.push_back(number(choice, rest.substr(0, comma)));
    rest = comma == std::string_view::npos ? "" : rest.substr(comma + 1);
  }
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  if (list.empty() || list.back() >= patterns) {
    refuse(choice, "the input's patterns are numbered 0 to " + std::to_string(patterns - 1));
  }
  if (static_cast<int>(list.size()) == patterns) refuse(choice, "no pattern is left to fit");
  return list;
}

}  // namespace

std::string to_string(ValidationChoice::Source source) {
  switch (source) {
    case ValidationChoice::Source::fitted_input:
      return "input";
    case ValidationChoice::Source::validation:
      return "validation";
    default:
      return "none";
  }
}

ValidationChoice choose_validation(const std::string& choice,
                                   const SurfaceMeasurements& measurements,
                                   ValidationMeasurements validation) {
  const bool has_validation = validation == ValidationMeasurements::present;
  using Source = ValidationChoice::Source;
  const int patterns = measurements.patterns;
  if (choice == "none") {
    return {has_validation ? Source::validation : Source::none, {}, std::nullopt};
  }
  if (choice == "auto") {
    if (has_validation) return {Source::validation, {}, std::nullopt};
    const int count = inverse::usual_validation_count(inverse::count_lights(measurements));
    if (count > 0) {
      return {Source::fitted_input, inverse::choose_validation_patterns(measurements, count),
              std::nullopt};
    }
    return {Source::none,
            {},
            "With only " + std::to_string(patterns) + (patterns == 1 ? " pattern" : " patterns") +
                " none is kept out of the fit for validation."};
  }
  if (has_validation) {
    refuse(choice,
           "the input has measurements of validation patterns, which are kept out already; leave "
           "the option away");
  }
  std::vector<int> list;
  if (choice.find(',') != std::string::npos) {
    list = listed(choice, patterns);
  } else {
    const int count = number(choice, choice);
    if (count >= patterns) {
      refuse(choice, "the input has " + std::to_string(patterns) + " patterns; keep out fewer");
    }
    list = inverse::choose_validation_patterns(measurements, count);
  }
  const Source source = list.empty() ? Source::none : Source::fitted_input;
  return {source, std::move(list), std::nullopt};
}

}  // namespace kappamu::pipeline
