#include "pipeline/stages/fit_stage.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "calib/calibration_file.h"
#include "core/numbers/coefficient_bounds.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "core/shown_text.h"
#include "core/surface_measurements.h"
#include "core/threads/side_by_side.h"
#include "inverse/data_checks/mirrored_light.h"
#include "inverse/fit/fit_memory.h"
#include "inverse/fit/fit_run.h"
#include "inverse/fit/fit_uncertainty.h"
#include "inverse/validation/notes.h"
#include "inverse/validation/validated_fit.h"
#include "io/atomic_file.h"
#include "io/volume/npy_volume.h"
#include "io/volume/volume_file.h"
#include "pipeline/fit_files.h"
#include "pipeline/lit_pixels.h"
#include "pipeline/records/channel_json.h"
#include "pipeline/records/fingerprint.h"
#include "pipeline/records/fit_options.h"
#include "pipeline/stages/checkpoint_files.h"
#include "pipeline/stages/continuation.h"
#include "pipeline/stages/fit_evidence.h"
#include "pipeline/stages/fit_output.h"
#include "pipeline/stages/square_check.h"
#include "pipeline/stages/validation_choice.h"
#include "pipeline/surface_reflectance.h"

namespace kappamu::pipeline {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using inverse::ChannelFit;

/// Data that no block explains may drive voxels beyond the coefficients that volumes may hold. The
/// fit's warnings tell of such data; its files are read by every later stage.
void keep_readable(Medium& medium) {
  constexpr double least = 1.000001 * least_kappa;  // as a float, too, it is no less
  for (double& kappa : medium.kappa.values()) kappa = std::clamp(kappa, least, most_coefficient);
  for (double& mu : medium.mu.values()) mu = std::min(mu, most_coefficient);
}

/// Every channel's fit, side by side where memory allows, then every channel's deviations: the
/// whole of run_fit_stage but finding the folders.
class FitStage {
 public:
  /// `validation`: measurements of their own that validate the fit.
  FitStage(fs::path input, const SurfaceMeasurements& measurements,
           std::optional<SurfaceMeasurements> validation, fs::path output, const LitPixels& lit,
           Progress& progress)
      : input_(std::move(input)),
        measurements_(measurements),
        lit_(lit),
        choice_(choose_validation(
            lit.options.hold_out, measurements,
            validation ? ValidationMeasurements::present : ValidationMeasurements::absent)),
        split_(inverse::split_validation(measurements, choice_.patterns, std::move(validation))),
        output_(std::move(output)),
        options_(lit.options),
        progress_(progress) {
    if (choice_.warning) progress_.warn(*choice_.warning);
    const fs::path calibration = input_ / "calibration";
    if (fs::exists(calibration / "calibration.json")) {
      calibration_ = calib::load_calibration(calibration);
    }
    if (options_.continue_from) {
      continued_.emplace(*options_.continue_from);
      continued_->require_continuable(options_, choice_.patterns);
    }
  }

  FitSummary run();

 private:
  /// Of the fit that is validated, and of what follows with all patterns.
  std::array<CheckpointFiles, 2> checkpoint_files(const std::string& name) const {
    const std::size_t most = inverse::most_checkpoint_bytes(measurements_, options_.fit);
    return {CheckpointFiles(output_ / ("checkpoint_" + name + ".bin"), most),
            CheckpointFiles(output_ / ("checkpoint_all_" + name + ".bin"), most)};
  }
  inverse::Checkpoint checkpoint(CheckpointFiles files) const;
  /// By the volume of the `c`-th channel fitted.
  const SurfaceMeasurements& seen_by(std::size_t c) const {
    return rejoined_[c] ? measurements_ : split_.fitted;
  }
  inverse::ValidatedFit fit(int channel, Progress& progress) const;
  ChannelFit keep(int channel, inverse::ValidatedFit fitted);
  void warn(ChannelFit& fit, const std::string& channel, const std::string& sentence);
  void state_deviations(std::span<const ChannelFit> fits, std::span<const int> channels);
  void keep_prediction(const ChannelFit& fit, bool of_all);
  void keep_reflectance(const std::vector<int>& channels);
  void write_json() const;

  fs::path input_;
  const SurfaceMeasurements& measurements_;
  const LitPixels& lit_;
  ValidationChoice choice_;
  inverse::ValidationSplit split_;
  std::optional<calib::CalibrationResult>
      calibration_;  ///< of the run that is fitted, if it is one
  std::optional<FinishedFit> continued_;
  fs::path output_;
  const FitStageOptions& options_;
  Progress& progress_;
  FitSummary summary_;
  std::vector<bool> rejoined_;  ///< by channel fitted: its volume has seen every pattern
  io::VolumeSet volumes_;
  std::vector<float> prediction_;
  std::vector<float> validation_prediction_;
  Json reflectance_;  ///< of the lit face's surface
};

inverse::Checkpoint FitStage::checkpoint(CheckpointFiles files) const {
  inverse::Checkpoint checkpoint;
  checkpoint.program = program_fingerprint();
  if (!options_.restart) checkpoint.load = [files]() mutable { return files.load(); };
  checkpoint.save = [files](std::span<const std::byte> bytes) { files.save(bytes); };
  return checkpoint;
}

inverse::ValidatedFit FitStage::fit(int channel, Progress& progress) const {
  const std::string& name = measurements_.channels[static_cast<std::size_t>(channel)];
  const auto [first, second] = checkpoint_files(name);
  std::optional<inverse::Continuation> start;
  if (continued_) start = continued_->channel(name, measurements_);
  return inverse::fit_validated(split_, channel, options_.fit, checkpoint(first),
                                checkpoint(second), progress, {}, start);
}

/// Its volumes, its words and its row of the summary.
ChannelFit FitStage::keep(int channel, inverse::ValidatedFit fitted) {
  const std::string& name = measurements_.channels[static_cast<std::size_t>(channel)];
  ChannelFit& result = fitted.fit;
  keep_readable(result.medium);
  if (fitted.validated) keep_readable(*fitted.validated);
  if (fitted.validated) {
    fs::create_directories(output_ / validated_folder);
    io::write_npy_volume(output_ / validated_folder / ("kappa_" + name + ".npy"),
                         fitted.validated->kappa);
    io::write_npy_volume(output_ / validated_folder / ("mu_" + name + ".npy"),
                         fitted.validated->mu);
  }
  rejoined_.push_back(fitted.validated.has_value());
  const SurfaceMeasurements& seen = seen_by(rejoined_.size() - 1);
  std::vector<int> kept_out;
  if (!rejoined_.back() && choice_.source == ValidationChoice::Source::fitted_input) {
    kept_out = choice_.patterns;
  }
  for (const auto& warning : {inverse::unseen_warning(result, seen, channel),
                              inverse::outlier_warning(result, seen, channel, kept_out)}) {
    if (warning) warn(result, name, *warning);
  }
  summary_.notes.push_back(inverse::notes_on(result, seen, fitted.score));
  if (!lit_.note.empty()) summary_.notes.back().insert(summary_.notes.back().begin(), lit_.note);
  io::write_npy_volume(output_ / ("kappa_" + name + ".npy"), result.medium.kappa);
  io::write_npy_volume(output_ / ("mu_" + name + ".npy"), result.medium.mu);
  if (result.sensitivity_mu.size() > 0) {
    write_sensitivity(output_, name, result, volumes_);
  }
  if (fitted.score) summary_.validation.push_back(std::move(*fitted.score));
  keep_prediction(result, fitted.validated.has_value());
  volumes_.channels.push_back(name);
  summary_.channels.push_back(name);
  summary_.device = result.report.backend;
  return std::move(result);
}

void FitStage::warn(ChannelFit& fit, const std::string& channel, const std::string& sentence) {
  fit.report.warnings.push_back(sentence);
  progress_.warn("fit " + channel + ": " + sentence);
}

/// Of every channel fitted: volumes share a contrast, so that no channel's can be known before the
/// last fit has ended.
void FitStage::state_deviations(std::span<const ChannelFit> fits, std::span<const int> channels) {
  const inverse::SharedDeviation shared = inverse::shared_deviation(fits, measurements_.lit_face);
  for (std::size_t c = 0; c < fits.size(); ++c) {
    const ChannelFit& fit = fits[c];
    summary_.uncertainty.emplace_back();
    const bool of_volume = fit.report.model.model == inverse::Model::volume;
    if (options_.fit.uncertainty.probes == 0 || (of_volume && !fit.prior)) continue;
    progress_.update("fit " + summary_.channels[c], 1.0, "standard deviations");
    inverse::Uncertainty found =
        of_volume ? inverse::estimate_volume_uncertainty(fit, shared, seen_by(c))
                  : inverse::estimate_model_uncertainty(fit, seen_by(c), channels[c], options_.fit);
    write_uncertainty(output_, summary_.channels[c], found, fit.medium, volumes_);
    summary_.uncertainty.back() = std::move(found.report);
  }
}

/// prediction.npy has every pattern of the input, validation patterns as the volumes predict them
/// that did not see them; prediction_validate.npy has those measured apart. `of_all`:
/// fit.prediction has every pattern.
void FitStage::keep_prediction(const ChannelFit& fit, bool of_all) {
  const std::size_t cells = measurements_.seen_shape().cells();
  std::vector<int> fitted;
  for (int m = 0; m < measurements_.patterns; ++m) {
    const auto& out = choice_.patterns;
    if (of_all || std::find(out.begin(), out.end(), m) == out.end()) fitted.push_back(m);
  }
  std::vector<float> all(cells * static_cast<std::size_t>(measurements_.patterns));
  put_patterns(all, cells, fitted, fit.prediction);
  if (split_.validation) {
    const std::vector<float>& predicted = summary_.validation.back().prediction;
    if (choice_.source == ValidationChoice::Source::fitted_input) {
      put_patterns(all, cells, choice_.patterns, predicted);
    } else {
      validation_prediction_.insert(validation_prediction_.end(), predicted.begin(),
                                    predicted.end());
    }
  }
  prediction_.insert(prediction_.end(), all.begin(), all.end());
}

/// Of the lit face's surface, where its pictures show it ([W] 6.1).
void FitStage::keep_reflectance(const std::vector<int>& channels) {
  // A fit that takes all light of lit pixels as scattered leaves nothing to the surface.
  if (lit_.used || (channels.size() != 1 && channels.size() != 3)) return;
  std::optional<Rigid> camera;
  if (calibration_) {
    camera =
        (measurements_.two_faces() ? calibration_->calibration_pose : calibration_->pattern_pose)
            .camera_from_sample;
  }
  const auto found = surface_reflectance(measurements_, channels, prediction_, camera);
  if (!found) return;
  reflectance_ = {{"file", write_surface_reflectance(output_, *found)},
                  {"face", to_string(found->face)},
                  {"measured", found->measured},
                  {"channels", Json::array()}};
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const SurfaceReflectance::Channel& channel = found->channels[c];
    reflectance_["channels"].push_back({{"name", channel.name},
                                        {"mean", channel.mean},
                                        {"noise", channel.noise},
                                        {"negative", channel.negative}});
    summary_.notes[c].push_back(
        "Under even light the lit face sends back " + shown_number(channel.mean, "%.2g") +
        " of the light more than the volume scatters: the reflectance of its surface, and what "
        "diffusion errs by.");
  }
}

void FitStage::write_json() const {
  Json channels = Json::array();
  std::vector<std::string> warnings;
  if (choice_.warning) warnings.push_back(*choice_.warning);
  for (std::size_t c = 0; c < summary_.channels.size(); ++c) {
    Json channel = channel_json(summary_.channels[c], summary_.reports[c]);
    channel["notes"] = summary_.notes[c];
    if (split_.validation) {
      channel["validation_E"] = summary_.validation[c].error.E();
      channel["validation_noise_E"] = summary_.validation[c].error.noise_E();
      channel["validation_chi2_per_value"] = summary_.validation[c].chi2_per_value;
      channel["validation_values_used"] = summary_.validation[c].error.count;
    }
    if (summary_.uncertainty[c]) {
      channel["uncertainty"] = uncertainty_json(*summary_.uncertainty[c]);
    }
    channels.push_back(std::move(channel));
    for (const std::string& w : summary_.reports[c].warnings) {
      warnings.push_back(summary_.channels[c] + ": " + w);
    }
  }
  Json fit{{"format", "kappamu-fit"}, {"version", 1}};
  add_fit_record(summary_.record, fit);
  fit["voxel_mm"] = measurements_.grid.voxel_mm;
  fit["eta"] = measurements_.eta;
  fit["device"] = summary_.device;
  fit["seconds"] = summary_.seconds;
  fit["memory_needed_bytes"] = summary_.memory_needed;
  fit["memory_peak_bytes"] = peak_memory();
  fit["input"] = input_.string();
  fit["options"] = Json::parse(options_json(options_));
  fit["lit_pixels"] = lit_.used;
  if (!reflectance_.is_null()) fit["surface_reflectance"] = reflectance_;
  fit["validation"] = {{"source", to_string(choice_.source)}, {"patterns", choice_.patterns}};
  fit["channels"] = channels;
  fit["warnings"] = warnings;
  io::write_text_atomically(output_ / "fit.json", fit.dump(1) + "\n");
}

FitSummary FitStage::run() {
  const Stopwatch watch;
  fs::remove_all(output_ / validated_folder);
  const std::vector<int> channels = channels_of(measurements_, options_.channels);
  const inverse::FitMemory of_one = inverse::memory_needed(split_.fitted, options_.fit);
  const int at_once =
      inverse::fits_at_once(of_one, options_.fit.solver.backend, static_cast<int>(channels.size()));
  const inverse::FitMemory memory{at_once * of_one.device, at_once * of_one.host};
  summary_.memory_needed = memory.total();
  progress_.update("fit", 0.0, inverse::in_words(memory));
  if (const auto warning = inverse::warning_of(memory, main_memory())) progress_.warn(*warning);
  // Told before the fit, which may take hours.
  const auto mirrored = inverse::mirrored_light(measurements_, channels.front());
  if (mirrored) progress_.warn(*mirrored);
  std::vector<std::string> names;
  for (const int c : channels) names.push_back(measurements_.channels[static_cast<std::size_t>(c)]);
  std::vector<inverse::ValidatedFit> fitted(channels.size());
  side_by_side("fit", names, at_once, progress_,
               [&](std::size_t c, Progress& progress) { fitted[c] = fit(channels[c], progress); });
  std::vector<ChannelFit> fits;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    fits.push_back(keep(channels[c], std::move(fitted[c])));
  }
  if (mirrored)
    fits.front().report.warnings.insert(fits.front().report.warnings.begin(), *mirrored);
  std::vector<inverse::Consistency> consistency;
  for (const ChannelFit& fit : fits) consistency.push_back(fit.report.consistency);
  const std::vector<ShiftFindings> shifts = check_shift(consistency, calibration_, measurements_);
  for (std::size_t c = 0; c < fits.size(); ++c) {
    for (const std::string& w : shifts[c].warnings) warn(fits[c], summary_.channels[c], w);
    for (const std::string& note : shifts[c].notes) summary_.notes[c].push_back(note);
  }
  state_deviations(fits, channels);
  for (ChannelFit& fit : fits) {
    volumes_.media.push_back(std::move(fit.medium));
    summary_.reports.push_back(std::move(fit.report));
  }
  write_maps(output_ / "prediction.npy", measurements_, summary_.channels.size(), prediction_);
  keep_reflectance(channels);
  if (choice_.source == ValidationChoice::Source::validation) {
    write_maps(output_ / "prediction_validate.npy", *split_.validation, summary_.channels.size(),
               validation_prediction_);
  }
  // A volume file has them for every channel or for none.
  if (volumes_.kappa_std.size() < volumes_.channels.size()) {
    for (auto* kept : {&volumes_.kappa_std, &volumes_.mu_std, &volumes_.kappa_resolution,
                       &volumes_.mu_resolution}) {
      kept->clear();
    }
  }
  volumes_.eta = measurements_.eta;
  volumes_.metadata = {{"program", "kappamu fit"}, {"device", summary_.device}};
  summary_.volume = output_ / "volume.vdb";
  io::write_vdb(summary_.volume, volumes_);
  summary_.seconds = watch.seconds();
  summary_.record = make_fit_record(summary_, split_.fitted, choice_, calibration_, input_);
  write_json();
  for (const std::string& name : summary_.channels) {
    for (const CheckpointFiles& files : checkpoint_files(name)) files.remove();
  }
  return std::move(summary_);
}

}  // namespace

FitSummary run_fit_stage(const fs::path& input, const fs::path& output,
                         const FitStageOptions& options, Progress& progress) {
  FitInput read = read_fit_input(input, options);
  const LitPixels lit = choose_lit_pixels(read, options);
  if (!lit.note.empty()) progress.update("fit", 0.0, lit.note);
  return FitStage(fs::absolute(input).lexically_normal(), read.measurements,
                  std::move(read.validation), output, lit, progress)
      .run();
}

}  // namespace kappamu::pipeline
