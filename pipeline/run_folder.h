// A run folder while stages fill it: which are done, which go on where they were killed, and which
// start afresh because their inputs changed.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/progress.h"
#include "pipeline/records/run_record.h"

namespace kappamu::pipeline {

class RunFolder {
 public:
  /// Opens or makes `folder` for results from `input` (of `kind`; `input_fingerprint` is that of
  /// session.json or measurements.json) and locks it against a second kappamu. Throws InputError
  /// when it holds the results of another input, unless `force`, or is locked.
  RunFolder(const std::filesystem::path& folder, RunRecord::InputKind kind,
            const std::filesystem::path& input, const std::string& input_fingerprint, bool force);
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  const RunRecord& record() const { return record_; }
  /// What the report prints; stored with the next stage.
  void set_options(std::map<std::string, std::string> options);
  void set_device(const std::string& device) { record_.device = device; }
  void set_holdout_error(std::map<std::string, double> by_channel) {
    record_.holdout_error = std::move(by_channel);
  }

  struct Stage {
    std::string name;  ///< one of stage_names
    std::string key;   ///< fingerprint of everything its outputs depend on
    /// Files and folders of the run that the stage writes. Present from an earlier, interrupted
    /// attempt with the same key they stay, for the stage to continue; otherwise they are removed.
    std::vector<std::string> outputs;
  };

  /// Whether the stage is complete with this key and its outputs are there.
  bool is_done(const Stage& stage) const;

  /// Does `work` unless the stage is done; returns whether it did. run.json says "started" before
  /// and "done" after; warnings and wall time are recorded.
  bool run(const Stage& stage, Progress& progress, const std::function<void(Progress&)>& work);

 private:
  std::filesystem::path folder_;
  RunRecord record_;
  bool force_ = false;
  int lock_ = 0;  ///< file descriptor of run.lock
};

}  // namespace kappamu::pipeline
