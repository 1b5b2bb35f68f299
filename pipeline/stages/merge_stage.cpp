#include "pipeline/stages/merge_stage.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "calib/calibration_file.h"
#include "calib/measure.h"
#include "capture/radiance/ambient.h"
#include "capture/radiance/merge.h"
#include "io/measurements_file.h"
#include "pipeline/stages/hdr_file.h"

namespace kappamu::pipeline {

namespace {

namespace fs = std::filesystem;
using capture::Pattern;
using capture::PatternRole;

// Each holds a whole stack of frames: more would cost memory rather than gain time.
constexpr unsigned most_threads = 8;

fs::path hdr_file(const fs::path& output, const std::string& pattern) {
  return output / "hdr" / (pattern + ".exr");
}

/// Merges and writes what is not there yet; the first failure in the session's order is thrown.
void merge_patterns(const capture::Session& session, const capture::Radiometry& radiometry,
                    const capture::MergeOptions& options, const fs::path& output,
                    Progress& progress) {
  const std::size_t count = session.patterns.size();
  std::vector<std::exception_ptr> failures(count);
  std::vector<std::vector<std::string>> notes(count);
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  std::mutex mutex;
  std::size_t finished = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < count && !failed; i = next++) {
      const Pattern& pattern = session.patterns[i];
      try {
        const fs::path file = hdr_file(output, pattern.id);
        if (fs::exists(file)) {
          notes[i] = read_hdr_notes(file);
        } else {
          const capture::HdrImage image = capture::merge_stack(
              session, pattern.frames, "pattern " + pattern.id, radiometry, options, &notes[i]);
          write_hdr(file, image, session.channels, notes[i]);
        }
        const std::lock_guard lock(mutex);
        ++finished;
        progress.update("merge", static_cast<double>(finished) / static_cast<double>(count),
                        pattern.id);
      } catch (...) {
        failures[i] = std::current_exception();
        failed = true;
      }
    }
  };
  {
    const unsigned threads = std::clamp(std::thread::hardware_concurrency(), 1U, most_threads);
    std::vector<std::jthread> others;
    for (unsigned i = 1; i < threads; ++i) others.emplace_back(work);
    work();
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  for (const auto& of_pattern : notes)
    for (const std::string& note : of_pattern) progress.warn(note);
}

/// Room light that changed by more than the measurements are good to (calib::MeasureOptions).
void warn_of_changing_room(const capture::AmbientLight& ambient, double pattern_light,
                           Progress& progress) {
  constexpr double worth_a_warning = 0.001;  // of a pattern's light
  if (!(ambient.half_range > worth_a_warning * pattern_light)) return;
  const auto percent = [](double share) {
    char text[16];
    std::snprintf(text, sizeof text, "%.2g", 100.0 * share);
    return std::string(text);
  };
  progress.warn("the room's light was " + percent(ambient.total / pattern_light) +
                " % of a pattern's in the photographs and changed by " +
                percent(2.0 * ambient.half_range / ambient.total) +
                " % between them (calibration.ambient), which leaves the patterns uncertain by " +
                percent(ambient.half_range / pattern_light) + " %: darken the room.");
}

void measure_patterns(const capture::Session& session, const calib::CalibrationResult& calibration,
                      const std::optional<capture::AmbientLight>& ambient, PatternRole role,
                      const fs::path& output, const fs::path& folder, Progress& progress) {
  const auto count = std::count_if(session.patterns.begin(), session.patterns.end(),
                                   [&](const Pattern& pattern) { return pattern.role == role; });
  if (count == 0) return;
  double patterns_light = 0.0;
  const auto hdr = [&](const std::string& id) {
    capture::HdrImage picture = read_hdr(hdr_file(output, id), session.channels);
    if (ambient) {
      capture::take_off(ambient->mean, picture);
      patterns_light += capture::total_light(picture);
    }
    return picture;
  };
  io::write_measurements(folder, calib::measure_surface(session, calibration, role, hdr, progress));
  if (ambient)
    warn_of_changing_room(*ambient, patterns_light / static_cast<double>(count), progress);
}

}  // namespace

void run_merge_stage(const capture::Session& session, const capture::HdrOptions& hdr,
                     const std::optional<fs::path>& calibrated, const fs::path& output,
                     Progress& progress) {
  std::optional<calib::CalibrationResult> calibration;
  if (calibrated) calibration = calib::load_calibration(*calibrated);
  merge_patterns(session,
                 calibration ? calibration->radiometry
                             : capture::find_radiometry(session, progress, hdr.response),
                 hdr.merge, output, progress);
  if (!calibration) {
    progress.warn(
        "there is no calibration in the run folder, so only HDR images were written; run `kappamu "
        "calibrate` first to get surface measurements");
    return;
  }
  std::vector<std::string> notes;
  const auto ambient = capture::merge_ambient(session, calibration->radiometry, hdr.merge, &notes);
  for (const std::string& note : notes) progress.warn(note);
  measure_patterns(session, *calibration, ambient, PatternRole::fit, output,
                   output / "measurements", progress);
  measure_patterns(session, *calibration, ambient, PatternRole::validate, output,
                   output / "measurements_validate", progress);
}

}  // namespace kappamu::pipeline
