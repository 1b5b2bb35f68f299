#include "pipeline/sfdi/sfdi_series.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <optional>

#include "core/error.h"
#include "core/file_name.h"
#include "core/shown_text.h"

namespace kappamu::pipeline::sfdi {

namespace {

namespace fs = std::filesystem;

/// One of a list: its number and its value.
struct Step {
  std::size_t number = 0;
  double value = 0.0;
};

struct Place {
  Step wavelength, frequency, phase;
};

/// A name with its placeholders filled in.
class Rule {
 public:
  Rule(const std::string& text, std::string where, int first)
      : text_(text), where_(std::move(where)), first_(first) {}

  bool empty() const { return text_.empty(); }
  bool has(const std::string& placeholder) const {
    return text_.find("{" + placeholder) != std::string::npos;
  }

  /// Throws InputError where names of several wavelengths or frequencies would be the same.
  void expect(const char* number, const char* value, std::size_t count) const {
    if (empty() || count < 2 || has(number) || has(value)) return;
    throw InputError(where_ + " is '" + shown_name(text_) + "' for " + std::to_string(count) +
                     " of them; put {" + number + "} or {" + value + "} into the name");
  }

  std::string at(const Place& place) const {
    std::string result;
    for (std::size_t i = 0; i < text_.size();) {
      if (text_[i] != '{') {
        result += text_[i++];
        continue;
      }
      const std::size_t end = text_.find('}', i);
      if (end == std::string::npos) refuse(text_.substr(i));
      result += filled(text_.substr(i + 1, end - i - 1), place);
      i = end + 1;
    }
    return result;
  }

 private:
  [[noreturn]] void refuse(const std::string& placeholder) const {
    throw InputError(where_ + " has '" + shown_name(placeholder) +
                     "'; use {wavelength}, {frequency}, {phase}, {wavelength_nm}, {per_mm} or "
                     "{phase_degrees}");
  }

  std::string filled(const std::string& placeholder, const Place& place) const {
    const std::size_t colon = placeholder.find(':');
    const std::string name = placeholder.substr(0, colon);
    if (name == "wavelength_nm") return shown_number(place.wavelength.value);
    if (name == "per_mm") return shown_number(place.frequency.value);
    if (name == "phase_degrees") return shown_number(place.phase.value);
    std::size_t number = static_cast<std::size_t>(first_);
    if (name == "wavelength") {
      number += place.wavelength.number;
    } else if (name == "frequency") {
      number += place.frequency.number;
    } else if (name == "phase") {
      number += place.phase.number;
    } else {
      refuse("{" + placeholder + "}");
    }
    std::string digits = std::to_string(number);
    if (colon != std::string::npos) {
      const std::string width = placeholder.substr(colon + 1);
      if (width.size() != 1 || std::isdigit(static_cast<unsigned char>(width[0])) == 0) {
        refuse("{" + placeholder + "}");
      }
      const auto wanted = static_cast<std::size_t>(width[0] - '0');
      if (digits.size() < wanted) digits.insert(0, wanted - digits.size(), '0');
    }
    return digits;
  }

  std::string text_, where_;
  int first_;
};

std::vector<Step> steps(const std::vector<double>& values) {
  std::vector<Step> result;
  for (const double value : values) result.push_back({result.size(), value});
  return result;
}

}  // namespace

std::vector<Pictures> pictures_of(const Series& series, const fs::path& folder,
                                  const std::string& file) {
  const int first = series.first_number.value_or(0);
  if (first < 0) {
    throw InputError(file + ": series.first_number is " + std::to_string(first) +
                     "; numbers in names start at 0, 1 or above");
  }
  const Rule sample(series.sample, file + ": series.sample", first);
  const Rule reference(series.reference, file + ": series.reference", first);
  const Rule dark(series.dark, file + ": series.dark", first);
  for (const Rule* rule : {&sample, &reference}) {
    rule->expect("wavelength", "wavelength_nm", series.wavelengths_nm.size());
    rule->expect("frequency", "per_mm", series.per_mm.size());
  }
  const auto phases = steps(series.phases_degrees);
  const auto named = [&](const Rule& rule, Place place, bool even) {
    std::vector<std::string> names;
    if (rule.empty()) return names;
    if (!rule.has("phase") || series.content != Content::light) return std::vector{rule.at(place)};
    if (phases.empty()) {
      throw InputError(file +
                       ": series.phases_degrees is missing, and names have {phase}; list "
                       "the phases in the order of their numbers");
    }
    std::error_code ignored;
    for (const Step& phase : phases) {
      place.phase = phase;
      const std::string name = rule.at(place);
      if (even && !names.empty() && !fs::exists(folder / name, ignored)) break;
      names.push_back(name);
    }
    return names;
  };
  std::vector<Pictures> result;
  for (const Step& wavelength : steps(series.wavelengths_nm)) {
    for (const Step& frequency : steps(series.per_mm)) {
      const Place place{wavelength, frequency, {}};
      const bool even = frequency.value == 0.0;
      Pictures& p = result.emplace_back();
      p.wavelength_nm = wavelength.value;
      p.per_mm = frequency.value;
      p.direction_degrees = series.direction_degrees;
      p.sample = named(sample, place, even);
      p.reference = named(reference, place, even);
      if (!dark.empty()) p.dark = dark.at(place);
      if (!even) p.phases_degrees = series.phases_degrees;
      p.repeats = series.repeats;
      p.content = series.content;
      p.side = series.side;
    }
  }
  return result;
}

}  // namespace kappamu::pipeline::sfdi
