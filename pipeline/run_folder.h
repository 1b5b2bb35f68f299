// A run folder while stages fill it: which are done, which go on where they were killed, and which
// start afresh because their inputs changed.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/progress.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/run_record.h"

namespace kappamu::pipeline {

/// What becomes of a folder's results.
enum class Results {
  kept,     ///< those of another input are refused, stages that are done stay
  replaced  ///< every stage is done again, whatever the folder's input was
};

class RunFolder {
 public:
  /// Opens or makes `folder` for results from `input` (of `kind`; `input_fingerprint` is that of
  /// session.json or measurements.json) and locks it against a second kappamu. Throws InputError
  /// when it is not apart from the input, holds the results of another one that are kept, or is
  /// locked.
  RunFolder(const std::filesystem::path& folder, RunRecord::InputKind kind,
            const std::filesystem::path& input, const std::string& input_fingerprint,
            Results results);
  /// Opens a folder that has a run.json, as it is; stages are done again whatever their keys.
  explicit RunFolder(const std::filesystem::path& folder);

  const std::filesystem::path& path() const { return folder_; }
  const RunRecord& record() const { return record_; }
  /// What the report prints; stored with the next stage.
  void set_options(std::map<std::string, std::string> options);
  void set_inputs(std::vector<OwnedFile> files) { record_.inputs = std::move(files); }
  void set_device(const std::string& device) { record_.device = device; }
  void set_validation_error(std::map<std::string, double> by_channel) {
    record_.validation_error = std::move(by_channel);
  }

  struct Stage {
    std::string name;  ///< one of stage_names
    std::string key;   ///< fingerprint of everything its outputs depend on
    /// Files and folders of the run that the stage may write.
    std::vector<std::string> outputs;
    Interrupted interrupted = Interrupted::removed;
  };

  /// The key with which a stage is complete and its files are as it wrote them; nothing if they are
  /// not. Reads the files on the first call and keeps what it found.
  std::optional<std::string> done_key(const std::string& stage) const;
  /// Throws InputError naming the first file of a complete stage that is missing or changed.
  void require_whole(const std::string& stage) const;
  /// The same, of the files in `folder` by their sizes alone: pictures of many gigabytes of which
  /// little is looked at.
  void require_whole_but(const std::string& folder, const std::string& stage) const;

  /// Throws InputError when a file that is not the run's lies where the stage writes.
  void require_room(const Stage& stage);

  /// What a stage does: fills `output` as it would the run folder (output/hdr/...).
  using Work = std::function<void(const std::filesystem::path& output, Progress& progress)>;
  /// Does `work` unless the stage is done; returns whether it did. The files take the place of the
  /// stage's former ones when all are complete; warnings and wall time are recorded. Former files
  /// that were damaged are warned of. `written` is what `work` may add its files to, so that they
  /// are not read again.
  bool run(const Stage& stage, Progress& progress, const Work& work,
           const KnownFingerprints& written = {});

 private:
  static std::filesystem::path prepared(const std::filesystem::path& folder,
                                        const std::filesystem::path& input);
  StagedFiles files_of(const std::string& stage);
  void recover();
  /// The first file of a complete stage that is missing or changed; empty if all are whole.
  const std::string& damage(const std::string& stage) const;
  std::string damage_among(const std::vector<OwnedFile>& files) const;

  std::filesystem::path folder_;
  FolderLock lock_;
  RunRecord record_;
  mutable std::map<std::string, std::string> damage_;  ///< by stage: damage(), once read
  Results results_;
};

}  // namespace kappamu::pipeline
