#include "pipeline/stages/merge_stage.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "calib/calibration_file.h"
#include "calib/light/shared_error.h"
#include "calib/measure.h"
#include "capture/radiance/ambient.h"
#include "capture/radiance/merge.h"
#include "capture/session/frames.h"
#include "core/memory/kept_blocks.h"
#include "core/numbers/region.h"
#include "core/shown_text.h"
#include "io/measurements_file.h"
#include "pipeline/stages/hdr_file.h"

namespace kappamu::pipeline {

namespace {

namespace fs = std::filesystem;
using capture::Pattern;
using capture::PatternRole;

constexpr double gigabyte = 1e9;
/// Of the 3 GB that a merge may take, what stacks in flight and the picture that is being measured
/// share; the rest is for ambient light, footprints and the program.
constexpr double most_bytes = 2.4 * gigabyte;
/// Of them, what lies idle between two stacks: blocks of sizes that are not wanted all at once.
constexpr double spare_bytes = 0.25 * gigabyte;

/// Stacks merged while a picture is measured: one a core, as long as they fit in most_bytes; none
/// where one alone does not. Each holds the part of all its frames, the merged picture, and two
/// frames as they are read.
std::size_t pictures_ahead(const capture::Session& session, const Region& part,
                           Progress& progress) {
  std::size_t frames = 1;
  bool floats = false, cropped_late = session.camera.orientation.value_or(1) != 1 ||
                                      session.camera.encoding == capture::Encoding::response;
  for (const Pattern& pattern : session.patterns) {
    frames = std::max(frames, pattern.frames.size());
    for (const capture::Frame& frame : pattern.frames) {
      floats = floats || capture::is_float_frame(session, frame);
      cropped_late = cropped_late || floats || capture::is_raw_frame(session, frame);
    }
  }
  const double channels = static_cast<double>(session.channels.size());
  const double value = floats ? sizeof(float) : sizeof(std::uint16_t);
  const double values = channels * part.width * part.height;
  const double whole = channels * session.camera.width * session.camera.height;
  const double picture = values * (2.0 * sizeof(float) + 1.0);  // radiance, variance, flags
  const double stack = values * static_cast<double>(frames) * value + picture +
                       whole * value * (cropped_late ? 2.0 : 1.0);
  if (stack > most_bytes) {
    progress.warn("a stack of " + std::to_string(frames) + " frames of " +
                  std::to_string(part.width) + " x " + std::to_string(part.height) +
                  " pixels takes about " + shown_number(stack / gigabyte, "%.1f") +
                  " GB of memory while it is merged: give it fewer exposures, or calibrate first, "
                  "so that the sample's surroundings alone are merged.");
  }
  return static_cast<std::size_t>(
      std::clamp((most_bytes - spare_bytes - picture) / stack, 0.0,
                 1.0 * std::max(1U, std::thread::hardware_concurrency())));
}

/// In the output folder.
std::string hdr_file(const std::string& pattern) {
  return "hdr/" + pattern + ".exr";
}

/// Merges patterns in threads, in the order given, writes what is not there yet, and hands each
/// picture over once: no more of them than threads wait for it at a time.
class MergedPatterns {
 public:
  MergedPatterns(const capture::Session& session, const capture::Radiometry& radiometry,
                 const capture::MergeOptions& options, fs::path output,
                 std::vector<const Pattern*> order, Progress& progress)
      : session_(session),
        radiometry_(radiometry),
        options_(options),
        output_(std::move(output)),
        order_(std::move(order)),
        merged_(order_.size()),
        part_(options_.part.value_or(Region{0, 0, session.camera.width, session.camera.height})),
        progress_(progress),
        ahead_(pictures_ahead(session, part_, progress)) {
    for (std::size_t i = 0; i < std::max<std::size_t>(ahead_, 1); ++i)
      workers_.emplace_back([this] { work(); });
  }
  MergedPatterns(const MergedPatterns&) = delete;
  MergedPatterns& operator=(const MergedPatterns&) = delete;
  ~MergedPatterns() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
  }

  /// The next picture of the order. Throws what merging it threw.
  capture::HdrImage take() {
    const std::size_t i = taken_;
    Merged merged;
    {
      std::unique_lock lock(mutex_);
      wanted_ = i + 1;
      changed_.notify_all();
      changed_.wait(lock, [&] { return merged_[i].has_value(); });
      merged = std::move(*merged_[i]);
      merged_[i].reset();
      ++taken_;
    }
    changed_.notify_all();
    if (merged.failure) std::rethrow_exception(merged.failure);
    for (const std::string& note : merged.notes) progress_.warn(note);
    if (!merged.fingerprint.empty()) written_[hdr_file(order_[i]->id)] = merged.fingerprint;
    progress_.update("merge", static_cast<double>(i + 1) / static_cast<double>(order_.size()),
                     order_[i]->id);
    return std::move(merged.picture);
  }
  bool done() const { return taken_ == order_.size(); }
  /// The fingerprints of those pictures that were taken, but those that were there before.
  const KnownFingerprints& written() const { return written_; }

 private:
  struct Merged {
    capture::HdrImage picture;
    std::vector<std::string> notes;
    std::string fingerprint;  ///< of the file, where it was written now
    std::exception_ptr failure;
  };

  void work() {
    while (true) {
      std::size_t i = 0;
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] {
          return stopped_ || next_ == order_.size() || next_ < std::max(wanted_, taken_ + ahead_);
        });
        if (stopped_ || next_ == order_.size()) return;
        i = next_++;
      }
      Merged merged = merge(*order_[i]);
      {
        const std::lock_guard lock(mutex_);
        merged_[i] = std::move(merged);
      }
      changed_.notify_all();
    }
  }

  Merged merge(const Pattern& pattern) const {
    Merged merged;
    try {
      const fs::path file = output_ / hdr_file(pattern.id);
      const bool exists = fs::exists(file);  // of an attempt that was interrupted
      if (exists) merged.picture = read_hdr(file, session_.channels, &merged.notes);
      if (!exists || merged.picture.place() != part_) {
        merged.notes.clear();
        merged.picture = capture::merge_stack(session_, pattern.frames, "pattern " + pattern.id,
                                              radiometry_, options_, &merged.notes);
        merged.fingerprint = write_hdr(file, merged.picture, session_, merged.notes);
      }
    } catch (...) {
      merged.failure = std::current_exception();
    }
    return merged;
  }

  const capture::Session& session_;
  const capture::Radiometry& radiometry_;
  const capture::MergeOptions& options_;
  fs::path output_;
  std::vector<const Pattern*> order_;
  std::vector<std::optional<Merged>> merged_;
  Region part_;
  Progress& progress_;
  std::size_t ahead_;
  KnownFingerprints written_;
  std::size_t next_ = 0, taken_ = 0, wanted_ = 0;
  bool stopped_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::jthread> workers_;  ///< last: they end before what they use
};

/// As the measurements ask for them: those of the fit, then those of validation.
std::vector<const Pattern*> in_order(const capture::Session& session) {
  std::vector<const Pattern*> order;
  for (const PatternRole role : {PatternRole::fit, PatternRole::validate})
    for (const Pattern& pattern : session.patterns)
      if (pattern.role == role) order.push_back(&pattern);
  return order;
}

/// Room light that changed by more than the measurements are good to (calib::MeasureOptions).
void warn_of_changing_room(const capture::AmbientLight& ambient, double pattern_light,
                           Progress& progress) {
  constexpr double worth_a_warning = 0.001;  // of a pattern's light
  if (!(ambient.half_range > worth_a_warning * pattern_light)) return;
  const auto percent = [](double share) { return shown_number(100.0 * share, "%.2g"); };
  progress.warn("the room's light was " + percent(ambient.total / pattern_light) +
                " % of a pattern's in the photographs and changed by " +
                percent(2.0 * ambient.half_range / ambient.total) +
                " % between them (calibration.ambient), which leaves the patterns uncertain by " +
                percent(ambient.half_range / pattern_light) + " %: darken the room.");
}

std::optional<calib::SharedError> measure_patterns(
    const capture::Session& session, const calib::CalibrationResult& calibration,
    const std::optional<capture::AmbientLight>& ambient, PatternRole role, MergedPatterns& merged,
    const fs::path& folder, Progress& progress, const calib::MeasureOptions& options) {
  const auto count = std::count_if(session.patterns.begin(), session.patterns.end(),
                                   [&](const Pattern& pattern) { return pattern.role == role; });
  if (count == 0) return std::nullopt;
  double patterns_light = 0.0;
  const auto hdr = [&](const std::string&) {
    capture::HdrImage picture = merged.take();
    if (ambient) {
      capture::take_off(ambient->mean, picture);
      patterns_light += capture::total_light(picture);
    }
    return picture;
  };
  SurfaceMeasurements measured =
      calib::measure_surface(session, calibration, role, hdr, progress, options);
  const calib::SharedError shared = calib::shared_error(session, calibration.white, measured);
  measured.smooth_error = shared.error;
  progress.update("merge", 1.0, "errors that neighbouring pixels share: " + shared.source);
  io::write_measurements(folder, measured, shared.source);
  if (ambient)
    warn_of_changing_room(*ambient, patterns_light / static_cast<double>(count), progress);
  return shared;
}

}  // namespace

std::optional<calib::SharedError> run_merge_stage(const capture::Session& session,
                                                  capture::MergeOptions hdr,
                                                  const std::optional<fs::path>& calibrated,
                                                  const fs::path& output, Progress& progress,
                                                  const calib::MeasureOptions& options,
                                                  KnownFingerprints* written) {
  const KeepsBlocks keeps(static_cast<std::size_t>(spare_bytes));  // one stack's for the next
  std::optional<calib::CalibrationResult> calibration;
  if (calibrated) {
    calibration = calib::load_calibration(*calibrated);
    hdr.part = calib::measured_part(session, *calibration);
  }
  const capture::Radiometry radiometry =
      calibration ? calibration->radiometry : capture::find_radiometry(session, progress);
  MergedPatterns merged(session, radiometry, hdr, output, in_order(session), progress);
  if (!calibration) {
    while (!merged.done()) merged.take();
    if (written != nullptr) *written = merged.written();
    progress.warn(
        "there is no calibration in the run folder, so only HDR images were written; run `kappamu "
        "calibrate` first to get surface measurements");
    return std::nullopt;
  }
  std::vector<std::string> notes;
  const auto ambient = capture::merge_ambient(session, radiometry, hdr, &notes);
  for (const std::string& note : notes) progress.warn(note);
  const auto shared = measure_patterns(session, *calibration, ambient, PatternRole::fit, merged,
                                       output / "measurements", progress, options);
  measure_patterns(session, *calibration, ambient, PatternRole::validate, merged,
                   output / "measurements_validate", progress, options);
  if (written != nullptr) *written = merged.written();
  return shared;
}

}  // namespace kappamu::pipeline
