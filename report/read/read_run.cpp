#include <algorithm>
#include <utility>

#include "calib/calibration_file.h"
#include "core/error.h"
#include "inverse/problem/lit_face.h"
#include "inverse/validation/validation_patterns.h"
#include "io/measurements_file.h"
#include "io/npy.h"
#include "report/read/run_data.h"

namespace kappamu::report {

namespace {

std::vector<std::size_t> value_shape(const SurfaceMeasurements& measured) {
  const FaceShape face = measured.seen_shape();
  return {measured.channels.size(), static_cast<std::size_t>(measured.patterns),
          static_cast<std::size_t>(face.nv), static_cast<std::size_t>(face.nu)};
}

/// Names of the session's patterns of one role, or numbered ones where the session is gone.
std::vector<std::string> pattern_names(const std::optional<capture::Session>& session,
                                       capture::PatternRole role, int count) {
  std::vector<std::string> names;
  if (session)
    for (const capture::Pattern& pattern : session->patterns)
      if (pattern.role == role) names.push_back(pattern.id);
  if (names.size() == static_cast<std::size_t>(count)) return names;
  names.clear();
  for (int i = 0; i < count; ++i) names.push_back("pattern " + std::to_string(i));
  return names;
}

std::optional<Comparison> read_comparison(const std::optional<capture::Session>& session,
                                          const std::filesystem::path& folder,
                                          const std::filesystem::path& prediction,
                                          capture::PatternRole role) {
  if (!std::filesystem::exists(folder / "measurements.json")) return std::nullopt;
  Comparison comparison;
  comparison.measured = io::read_measurements(folder);
  if (std::filesystem::exists(prediction))
    comparison.predicted = io::read_npy(prediction, value_shape(comparison.measured)).values;
  comparison.patterns = pattern_names(session, role, comparison.measured.patterns);
  return comparison;
}

/// Some of the patterns alone.
Comparison part_of(const Comparison& all, const std::vector<int>& patterns) {
  Comparison part;
  part.measured = inverse::select_patterns(all.measured, patterns);
  for (const int m : patterns) part.patterns.push_back(all.patterns[static_cast<std::size_t>(m)]);
  if (!all.predicted.empty()) {
    SurfaceMeasurements predicted = all.measured;
    predicted.value = all.predicted;
    part.predicted = inverse::select_patterns(predicted, patterns).value;
  }
  return part;
}

}  // namespace

void read_comparisons(RunData& data) {
  const std::filesystem::path& run = data.folder;
  const bool from_session =
      data.record && data.record->input_kind == pipeline::RunRecord::InputKind::session;
  // A run on someone's measurements reads them where they are.
  const std::filesystem::path own = run / "measurements";
  const std::filesystem::path measurements =
      !data.record || from_session || std::filesystem::exists(own) ? own : data.record->input;
  data.fit_patterns = read_comparison(data.session, measurements, run / "fit" / "prediction.npy",
                                      capture::PatternRole::fit);
  data.validate_patterns =
      read_comparison(data.session, run / "measurements_validate",
                      run / "fit" / "prediction_validate.npy", capture::PatternRole::validate);
  for (std::optional<Comparison>* patterns : {&data.fit_patterns, &data.validate_patterns}) {
    if (*patterns && data.fit && data.fit->lit_pixels) {
      inverse::use_lit_pixels((*patterns)->measured);
    }
  }
  if (data.fit_patterns && data.fit && !data.fit->validation.empty()) {
    const Comparison all = std::move(*data.fit_patterns);
    const std::vector<int>& validation = data.fit->validation;
    std::vector<int> fitted;
    for (int m = 0; m < all.measured.patterns; ++m) {
      if (std::find(validation.begin(), validation.end(), m) == validation.end())
        fitted.push_back(m);
    }
    data.fit_patterns = part_of(all, fitted);
    data.validate_patterns = part_of(all, validation);
  }
}

RunData read_run(const std::filesystem::path& run) {
  if (!std::filesystem::is_directory(run))
    throw InputError(run.string() + ": no such run folder; make one with `kappamu run`");
  RunData data;
  data.folder = std::filesystem::weakly_canonical(run);
  data.record = pipeline::read_run_record(run);
  const bool from_session =
      data.record && data.record->input_kind == pipeline::RunRecord::InputKind::session;
  if (from_session) {
    try {
      data.session = capture::read_session(data.record->input);
    } catch (const InputError&) {
      // The session may have been moved away since; the report says so.
      data.session.reset();
    }
  }
  if (std::filesystem::exists(run / "calibration" / "calibration.json")) {
    data.calibration = calib::load_calibration(run / "calibration");
  }
  if (data.session && data.calibration) {
    data.sample_pictures = sample_pictures(*data.session, *data.calibration);
  }
  data.hdr = summarise_hdr(run);
  data.fit = read_fit(run);
  read_comparisons(data);
  if (!data.calibration && data.hdr.empty() && !data.fit && !data.fit_patterns)
    throw InputError(run.string() +
                     ": holds nothing to report; run `kappamu run` or `kappamu fit` into it first");
  return data;
}

AppearanceError appearance_error(const Comparison& comparison, std::optional<std::size_t> pattern) {
  const SurfaceMeasurements& measured = comparison.measured;
  const std::size_t cells = measured.seen_shape().cells();
  const auto patterns = static_cast<std::size_t>(measured.patterns);
  AppearanceError error;
  for (std::size_t i = 0; i < comparison.predicted.size(); ++i) {
    if (pattern && *pattern != i / cells % patterns) continue;
    if (!measured.mask.empty() && measured.mask[i] == 0) continue;
    error.add(comparison.predicted[i], measured.value[i], measured.variance[i]);
  }
  return error;
}

Image<float> pattern_image(const SurfaceMeasurements& measured, const std::vector<float>& values,
                           std::size_t pattern) {
  const FaceShape face = measured.seen_shape();
  const int channels = measured.channels.size() == 3 ? 3 : 1;
  Image<float> image(face.nu, face.nv, channels);
  for (int c = 0; c < channels; ++c) {
    const std::size_t first =
        (static_cast<std::size_t>(c) * static_cast<std::size_t>(measured.patterns) + pattern) *
        face.cells();
    for (int v = 0; v < face.nv; ++v)
      for (int u = 0; u < face.nu; ++u)
        image(u, v, c) = values[first + static_cast<std::size_t>(v) * face.nu + u];
  }
  return image;
}

}  // namespace kappamu::report
