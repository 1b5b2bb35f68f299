#include "inverse/validation/validated_fit.h"

#include <string>
#include <utility>

#include "inverse/validation/simpler_model.h"

namespace kappamu::inverse {

namespace {

ValidationScore score_of(const ChannelFit& fit, const SurfaceMeasurements& validation, int channel,
                         const FitOptions& options) {
  return validation_score(fit.medium, validation, channel,
                          predict_options(options, fit.report.physics), options.data.model_error,
                          options.data.term);
}

StepRecord later(StepRecord record, const FitReport& before) {
  record.solves.add(before.solves);
  record.seconds += before.seconds;
  return record;
}

/// The report of both fits: the second's end, the first's history before it.
FitReport joined(FitReport first, FitReport second) {
  for (const StepRecord& record : second.history) first.history.push_back(later(record, first));
  if (second.status == FitStatus::ran_out || first.status == FitStatus::converged) {
    first.status = second.status;
    first.reason = std::move(second.reason);
  }
  for (std::string& sentence : second.warnings) first.warnings.push_back(std::move(sentence));
  const std::optional<VolumeErrors>& by_volume = second.consistency.by_volume;
  if (second.consistency.volume_shift) {
    first.consistency.set_by_volume(*by_volume);
  } else {
    first.consistency.by_volume = by_volume;
  }
  first.chi2_per_value = second.chi2_per_value;
  first.shared = second.shared;
  first.data = second.data;
  first.solves.add(second.solves);
  first.seconds += second.seconds;
  first.resumed = first.resumed || second.resumed;
  return first;
}

}  // namespace

ValidationSplit split_validation(const SurfaceMeasurements& all, std::span<const int> patterns,
                                 std::optional<SurfaceMeasurements> apart) {
  ValidationSplit input{all, without_patterns(all, patterns), std::move(apart), !patterns.empty()};
  if (input.rejoin) input.validation = select_patterns(all, patterns);
  return input;
}

ValidatedFit fit_validated(const ValidationSplit& input, int channel, const FitOptions& options,
                           const Checkpoint& first, const Checkpoint& second, Progress& progress,
                           const Observer& observer, const std::optional<Continuation>& continued) {
  if (input.validation) validate(*input.validation, "measurements for validation");
  FitContext context;
  context.continued = continued;
  context.interim = input.rejoin;
  FitOptions first_options = options;
  if (input.rejoin) first_options.uncertainty.probes = 0;
  ValidatedFit result;
  result.fit =
      fit_channel(input.fitted, channel, first_options, first, progress, observer, context);
  if (!input.validation) return result;
  if (!continued) prefer_simpler(result.fit, input.fitted, *input.validation, channel, options);
  result.score = score_of(result.fit, *input.validation, channel, options);
  if (!input.rejoin) return result;

  FitReport& report = result.fit.report;
  if (report.model.model != Model::volume) {
    // A handful of unknowns gains nothing by one pattern more.
    for (const std::string& sentence :
         volume_warnings(result.fit.medium, report, input.fitted, options)) {
      report.warnings.push_back(sentence);
      progress.warn("fit " + input.all.channels[static_cast<std::size_t>(channel)] + ": " +
                    sentence);
    }
    return result;
  }
  FitOptions all_options = options;
  all_options.path.weight = report.weight;
  all_options.data.physics = report.physics;
  FitContext all_context;
  all_context.continued = Continuation{result.fit.medium,     report.homogeneous_kappa,
                                       report.homogeneous_mu, report.homogeneous_log_residual,
                                       report.weight,         report.end};
  Observer all_observer;
  if (observer) {
    all_observer = [&](const StepRecord& record, const GridShape& shape,
                       const CoefficientPair& fields) {
      observer(later(record, report), shape, fields);
    };
  }
  ChannelFit all =
      fit_channel(input.all, channel, all_options, second, progress, all_observer, all_context);
  all.report = joined(std::move(report), std::move(all.report));
  result.validated = std::move(result.fit.medium);
  result.fit = std::move(all);
  return result;
}

}  // namespace kappamu::inverse
