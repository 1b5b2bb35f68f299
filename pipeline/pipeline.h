// The order of stages from a session, or from someone's measurements, to a report; which inputs
// each depends on; and which are done already.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "calib/light/shared_error.h"
#include "capture/radiance/merge.h"
#include "capture/session/session.h"
#include "capture/session/session_files.h"
#include "core/progress.h"
#include "pipeline/run_folder.h"
#include "pipeline/stages/fit_stage.h"

namespace kappamu::pipeline {

/// What a run is let do.
struct Permissions {
  bool replace_other_run = false;                 ///< `run` may hold results of another input
  capture::Links links = capture::Links::within;  ///< of a session's files
};

class Pipeline {
 public:
  /// `input` is a folder with session.json or with measurements.json. Throws InputError when it is
  /// neither or damaged, or needs a permission it does not have.
  Pipeline(const std::filesystem::path& input, const std::filesystem::path& run,
           const Permissions& permissions = {});

  /// How frames become radiance; before the first stage. Recorded in run.json.
  void set_hdr_options(const capture::MergeOptions& options);

  RunFolder& folder() { return folder_; }
  const std::optional<capture::Session>& session() const { return session_; }

  /// Before hours of work: throws InputError when a file that is not the run's lies where any stage
  /// writes.
  void require_room();

  // Each does its stage unless it is done with the same inputs; returns whether it had to.

  /// Needs a session.
  bool calibrate(Progress& progress);
  /// Needs a session; measures surfaces where the run is calibrated from it.
  bool merge(Progress& progress);
  /// What merge() found, where it measured surfaces just now.
  const std::optional<calib::SharedError>& shared_error() const { return shared_error_; }
  /// Fits the run's own measurements, or the input's where that is what the run was given.
  bool fit(const FitStageOptions& options, Progress& progress);
  bool export_all(Progress& progress);
  /// `write` makes the page `file` of a run folder (report/report.h).
  bool report(const std::function<void(const std::filesystem::path& run,
                                       const std::filesystem::path& file)>& write,
              Progress& progress);

 private:
  struct Input;
  static Input open_input(const std::filesystem::path& folder, const std::filesystem::path& run,
                          const Permissions& permissions);
  Pipeline(Input input, const std::filesystem::path& run, const Permissions& permissions);
  const capture::Session& require_session() const;
  RunFolder::Stage calibrate_stage() const;
  RunFolder::Stage merge_stage() const;
  /// A stage that depends on `earlier` and on nothing else but `options`.
  static RunFolder::Stage stage_after(const RunFolder::Stage& earlier, const std::string& name,
                                      const std::string& options, std::vector<std::string> outputs);

  std::optional<capture::Session> session_;
  capture::MergeOptions hdr_;
  std::string fingerprint_;  ///< of the input with all its files, and of this program
  RunFolder folder_;
  std::optional<calib::SharedError> shared_error_;
  RunFolder::Stage fit_stage_;  ///< set by fit(), for the stages after it
};

}  // namespace kappamu::pipeline
