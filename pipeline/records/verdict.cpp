#include "pipeline/records/verdict.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu::pipeline {

namespace {

using inverse::FitStatus;

constexpr double good_rms_px = 0.3;    // what the simulated rig reaches with room to spare
constexpr double usable_rms_px = 1.0;  // beyond, surface voxels mix at usual scales
constexpr double good_used = 0.9;      // back-lit: nearly the whole face should carry data
constexpr double usable_used = 0.5;
constexpr double usable_used_front_lit = 0.3;  // lit patches are left out by design
constexpr double low_chi2 = 0.1;               // below: variances overstated, or noise fitted
constexpr double explained_chi2 = 1.5;         // about 1 where model and variances are right
constexpr double usable_chi2 = 4.0;
constexpr double explained_mean = 2.0;  // stated errors of the mean
constexpr double good_E = 1e-3;
constexpr double usable_E = 1e-2;
constexpr double noise_margin =
    1.5;  // E within this factor of the noise's cannot be distinguished from it

std::string number(double value) {
  return shown_number(value, "%.3g");
}

Grade graded(double value, double good, double usable) {
  return value <= good ? Grade::green : value <= usable ? Grade::amber : Grade::red;
}

Criterion calibration(const FitEvidence& evidence) {
  if (!evidence.camera_rms_px || !evidence.projector_rms_px) {
    return {"Calibration", Grade::unknown, "the measurements come without a lens calibration"};
  }
  const double worst = std::max(*evidence.camera_rms_px, *evidence.projector_rms_px);
  return {"Calibration", graded(worst, good_rms_px, usable_rms_px),
          "reprojection RMS is " + number(*evidence.camera_rms_px) + " px (camera) and " +
              number(*evidence.projector_rms_px) + " px (projector), " +
              (worst <= good_rms_px ? "within " : "above the good ") + number(good_rms_px) + " px"};
}

Criterion coverage(const FitEvidence& evidence) {
  const bool front = evidence.front_lit;
  const double good = front ? usable_used : good_used;
  const double usable = front ? usable_used_front_lit : usable_used;
  return {"Coverage",
          evidence.used >= good     ? Grade::green
          : evidence.used >= usable ? Grade::amber
                                    : Grade::red,
          number(100.0 * evidence.used) + " % of the surface values are used" +
              (front ? " (lit ones are left out)" : "")};
}

bool is_explained(const FitEvidence::Channel& channel) {
  return channel.status != FitStatus::ran_out &&
         (channel.misfit() <= explained_chi2 || channel.systematic > 0.0) &&
         channel.shared.mean_off() <= explained_mean;
}

/// What the fitted patterns show of the errors that pixels share; empty where none are stated.
std::string shared_errors(const FitEvidence::Channel& channel) {
  const inverse::SharedErrors& shared = channel.shared;
  if (shared.stated == 0.0) return {};
  std::string words = ", " + channel.name + " is " + inverse::mean_in_words(shared);
  if (shared.mean_off() > explained_mean) {
    words += ", " + number(shared.mean_off()) + " times the stated error of the light";
  }
  if (shared.excess > explained_chi2) words += " and " + inverse::octave_in_words(shared);
  return words;
}

Criterion fit(const FitEvidence& evidence) {
  Criterion criterion{"Fit", Grade::green, "χ² per value is"};
  std::string unexplained, unfinished, low, systematic;
  bool by_octave = false;  // in a channel whose χ² of all values is within the bound
  const auto name = [](std::string& list, const std::string& channel) {
    list += (list.empty() ? "" : ", ") + channel;
  };
  for (const FitEvidence::Channel& channel : evidence.channels) {
    const double chi2 = channel.misfit();
    // Not a number is not within any bound.
    Grade grade = graded(std::isnan(chi2) ? INFINITY : chi2, explained_chi2, usable_chi2);
    if (grade != Grade::green && channel.systematic > 0.0) {
      grade = Grade::amber;
      name(systematic, channel.name + " " + number(100.0 * channel.systematic) + " %");
    } else if (grade != Grade::green) {
      name(unexplained, channel.name);
      by_octave = by_octave || channel.chi2_per_value <= explained_chi2;
    }
    if (channel.shared.mean_off() > explained_mean) {
      if (grade == Grade::green || channel.systematic > 0.0) name(unexplained, channel.name);
      grade = Grade::red;
    }
    if (channel.status == FitStatus::ran_out) name(unfinished, channel.name);
    const bool too_low = channel.chi2_per_value < low_chi2;
    if (too_low) name(low, channel.name);
    if (channel.status == FitStatus::ran_out || too_low) grade = std::max(grade, Grade::amber);
    criterion.grade = std::max(criterion.grade, grade);
    criterion.reason += (&channel == &evidence.channels.front() ? " " : ", ") + channel.name + " " +
                        number(channel.chi2_per_value);
  }
  criterion.reason +=
      unexplained.empty()
          ? ": the data are explained to their noise"
          : ": the data of " + unexplained + " are not explained to their noise (at most " +
                number(explained_chi2) + (by_octave ? ", in each octave of frequency)" : ")");
  if (!systematic.empty()) {
    criterion.reason += ", beside a systematic error of the data (" + systematic + ")";
  }
  if (!unfinished.empty()) criterion.reason += ", " + unfinished + " ran out of steps";
  for (const FitEvidence::Channel& channel : evidence.channels) {
    criterion.reason += shared_errors(channel);
  }
  if (!low.empty()) criterion.reason += ", the variances of " + low + " are overstated";
  return criterion;
}

Criterion validation(const FitEvidence& evidence) {
  Criterion criterion{"Validation", Grade::unknown, "no patterns were kept out of the fit"};
  const std::size_t count = evidence.validation.size();
  if (count == 0) return criterion;
  AppearanceError all;
  for (const AppearanceError& error : evidence.validation) all.add(error);
  const auto grade_of = [](const AppearanceError& error) {
    return error.E() <= noise_margin * error.noise_E() ? Grade::green
                                                       : graded(error.E(), good_E, usable_E);
  };
  criterion.grade = grade_of(all);
  criterion.reason = "E = " + number(all.E()) + " over " + std::to_string(count) +
                     (count == 1 ? " pattern" : " patterns") +
                     " that the fit did not see (noise alone: " + number(all.noise_E()) + ")";
  // The sum is that of the brightest: a dim pattern that is wrong must not hide behind them.
  const auto worst = std::max_element(evidence.validation.begin(), evidence.validation.end(),
                                      [](const auto& a, const auto& b) { return a.E() < b.E(); });
  if (grade_of(*worst) == Grade::red && criterion.grade == Grade::green) {
    criterion.grade = Grade::amber;
    criterion.reason +=
        ", above " + number(usable_E) + " in " +
        evidence.validation_names.at(static_cast<std::size_t>(worst - evidence.validation.begin()));
  }
  return criterion;
}

Criterion warnings(const FitEvidence& evidence) {
  if (evidence.warnings == 0) return {"Warnings", Grade::green, "none"};
  return {"Warnings", Grade::amber,
          std::to_string(evidence.warnings) + (evidence.warnings == 1 ? " warning" : " warnings") +
              " of calibration, merge and fit"};
}

std::string sentence_of(const Verdict& verdict) {
  if (verdict.grade == Grade::green) return "This fit can be trusted.";
  std::string reasons;
  for (const Criterion& criterion : verdict.criteria) {
    if (criterion.grade != verdict.grade) continue;
    reasons += (reasons.empty() ? "" : "; ") + criterion.reason;
  }
  return (verdict.grade == Grade::red ? "Do not trust this fit: " : "Usable with reservations: ") +
         reasons + ".";
}

Grade grade_from(const std::string& name) {
  for (const Grade grade : {Grade::green, Grade::amber, Grade::red}) {
    if (name == to_string(grade)) return grade;
  }
  return Grade::unknown;
}

}  // namespace

std::string to_string(Grade grade) {
  switch (grade) {
    case Grade::green:
      return "green";
    case Grade::amber:
      return "amber";
    case Grade::red:
      return "red";
    default:
      return "unknown";
  }
}

double FitEvidence::Channel::misfit() const {
  return std::max(chi2_per_value, shared.excess);
}

Verdict make_verdict(const FitEvidence& evidence) {
  check(!evidence.channels.empty(), "a verdict needs a fitted channel");
  Verdict verdict;
  verdict.explained = std::all_of(evidence.channels.begin(), evidence.channels.end(), is_explained);
  verdict.criteria = {fit(evidence), validation(evidence), coverage(evidence),
                      calibration(evidence), warnings(evidence)};
  for (const Criterion& criterion : verdict.criteria) {
    verdict.grade = std::max(verdict.grade, criterion.grade);
  }
  verdict.sentence = sentence_of(verdict);
  return verdict;
}

std::string overall_status(const std::vector<FitStatus>& channels) {
  // In the order of the enumeration each is worse than the one before.
  return inverse::to_string(*std::max_element(channels.begin(), channels.end()));
}

nlohmann::ordered_json verdict_json(const Verdict& verdict) {
  using Json = nlohmann::ordered_json;
  Json criteria = Json::array();
  for (const Criterion& criterion : verdict.criteria) {
    criteria.push_back({{"name", criterion.name},
                        {"grade", to_string(criterion.grade)},
                        {"reason", criterion.reason}});
  }
  return {{"grade", to_string(verdict.grade)},
          {"sentence", verdict.sentence},
          {"explained", verdict.explained},
          {"criteria", criteria}};
}

Verdict verdict_from_json(const nlohmann::json& object) {
  Verdict verdict;
  verdict.grade = grade_from(object.at("grade").get<std::string>());
  verdict.sentence = object.at("sentence").get<std::string>();
  verdict.explained = object.at("explained").get<bool>();
  for (const auto& criterion : object.at("criteria")) {
    verdict.criteria.push_back({criterion.at("name").get<std::string>(),
                                grade_from(criterion.at("grade").get<std::string>()),
                                criterion.at("reason").get<std::string>()});
  }
  return verdict;
}

}  // namespace kappamu::pipeline
