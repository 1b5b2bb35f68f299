// Whether to trust a fit, computed once, when it ends: terminal, --json, fit.json, the report and
// the exit code all show this verdict.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/appearance_error.h"
#include "inverse/fit/fit.h"

namespace kappamu::pipeline {

/// In rising order; unknown: nothing to decide by.
enum class Grade { unknown, green, amber, red };
std::string to_string(Grade grade);

/// One line of the verdict.
struct Criterion {
  std::string name;
  Grade grade = Grade::unknown;
  std::string reason;  ///< a clause without capital and full stop
};

struct Verdict {
  Grade grade = Grade::unknown;  ///< the worst of the criteria
  std::string sentence;          ///< where not green, with the reasons of that grade
  bool explained = false;        ///< every channel's data, to their noise, within the steps allowed
  std::vector<Criterion> criteria;

  /// 0, or 3 where the data are not explained or the grade is red.
  int exit_code() const { return explained && grade != Grade::red ? 0 : 3; }
};

/// What the verdict is made of.
struct FitEvidence {
  struct Channel {
    std::string name;
    inverse::FitStatus status = inverse::FitStatus::ran_out;
    double chi2_per_value = 0.0;     ///< of the fitted patterns
    double systematic = 0.0;         ///< error that the model accepted needs (ModelChoice), 0: none
    inverse::SharedErrors shared{};  ///< zeros where none are stated

    /// χ² per value, or what an octave of the errors that pixels share has beyond chance, if more.
    double misfit() const;
  };
  std::vector<Channel> channels;
  double used = 0.0;  ///< share of the fitted patterns' values that masks allow
  bool front_lit = false;
  /// Of each validation pattern, all channels together; empty without any.
  std::vector<AppearanceError> validation;
  std::vector<std::string> validation_names;  ///< as many
  std::optional<double> camera_rms_px;        ///< reprojection RMS, where the run is calibrated
  std::optional<double> projector_rms_px;
  std::size_t warnings = 0;  ///< of calibration, merge and fit
};

Verdict make_verdict(const FitEvidence& evidence);

/// "converged", or the worst status among the channels.
std::string overall_status(const std::vector<inverse::FitStatus>& channels);

nlohmann::ordered_json verdict_json(const Verdict& verdict);
/// Of verdict_json(). Throws nlohmann::json::exception for what is not.
Verdict verdict_from_json(const nlohmann::json& object);

}  // namespace kappamu::pipeline
