#include "pipeline/run_folder.h"

#include <algorithm>

#include "core/error.h"
#include "core/parallel.h"
#include "core/processor_time.h"
#include "pipeline/records/versions.h"

namespace kappamu::pipeline {

namespace {

namespace fs = std::filesystem;

/// Passes everything on and keeps the warnings for the record.
class RecordingProgress : public Progress {
 public:
  explicit RecordingProgress(Progress& listener) : listener_(listener) {}
  void update(const std::string& stage, double fraction, const std::string& detail) override {
    listener_.update(stage, fraction, detail);
  }
  void warn(const std::string& sentence) override {
    if (std::find(warnings_.begin(), warnings_.end(), sentence) != warnings_.end()) return;
    warnings_.push_back(sentence);
    listener_.warn(sentence);
  }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  Progress& listener_;
  std::vector<std::string> warnings_;
};

/// Nothing to go on with.
bool is_without_files(const fs::path& folder) {
  std::error_code error;
  const fs::recursive_directory_iterator entries(folder, error);
  return std::none_of(begin(entries), end(entries), [](const auto& entry) {
    return entry.is_symlink() || !entry.is_directory();
  });
}

}  // namespace

fs::path RunFolder::prepared(const fs::path& folder, const fs::path& input) {
  require_apart(folder, {input});
  fs::path made = canonical_path(folder);
  make_output_folder(made);
  return made;
}

RunFolder::RunFolder(const fs::path& folder, RunRecord::InputKind kind, const fs::path& input,
                     const std::string& input_fingerprint, Results results)
    : folder_(prepared(folder, input)), lock_(folder_, FolderLock::By::file), results_(results) {
  const std::optional<RunRecord> earlier = read_run_record(folder_);
  if (earlier && earlier->input_fingerprint != input_fingerprint && results == Results::kept)
    throw InputError(folder_.string() + ": holds a run of another input (" +
                         earlier->input.string() +
                         ", or what it was before an edit); choose another folder, or replace it",
                     {{"out"}, {"force"}});
  if (earlier) record_ = *earlier;
  recover();
  // Of another input nothing is done, but its files may be replaced.
  if (record_.input_fingerprint != input_fingerprint)
    for (auto& [name, stage] : record_.stages) stage.key.clear();
  record_.input_kind = kind;
  record_.input = fs::absolute(input).lexically_normal();
  record_.input_fingerprint = input_fingerprint;
  record_.versions = library_versions();
}

RunFolder::RunFolder(const fs::path& folder)
    : folder_(canonical_path(folder)),
      lock_(folder_, FolderLock::By::file),
      results_(Results::replaced) {
  const std::optional<RunRecord> earlier = read_run_record(folder_);
  if (!earlier) throw InputError(folder.string() + ": has no run.json; give a run folder");
  record_ = *earlier;
  recover();
}

StagedFiles RunFolder::files_of(const std::string& stage) {
  return {folder_, stage, Former::removed, record_.stages[stage],
          [this] { write_run_record(record_, folder_); }};
}

void RunFolder::recover() {
  remove_stale_record(folder_ / "run.json", "kappamu-run");
  for (const auto& [name, stage] : record_.stages)
    if (stage.status == StageStatus::moving) files_of(name).recover();
}

void RunFolder::require_room(const Stage& stage) {
  const bool known = record_.stages.contains(stage.name);
  files_of(stage.name).require_room(stage.outputs, Changed::replaced);
  if (!known) record_.stages.erase(stage.name);
}

void RunFolder::set_options(std::map<std::string, std::string> options) {
  record_.options = std::move(options);
}

const std::string& RunFolder::damage(const std::string& stage) const {
  const auto [found, is_new] = damage_.try_emplace(stage);
  if (is_new) found->second = damage_among(record_.stages.at(stage).files);
  return found->second;
}

std::string RunFolder::damage_among(const std::vector<OwnedFile>& files) const {
  std::vector<FileState> states(files.size());
  for_rows(static_cast<int>(files.size()), [&](int k) {
    states[static_cast<std::size_t>(k)] = state_of(folder_, files[static_cast<std::size_t>(k)]);
  });
  for (std::size_t k = 0; k < files.size(); ++k) {
    if (states[k] == FileState::whole) continue;
    return (folder_ / files[k].path).string() +
           (states[k] == FileState::missing ? " is missing" : " was changed");
  }
  return "";
}

std::optional<std::string> RunFolder::done_key(const std::string& stage) const {
  const auto found = record_.stages.find(stage);
  if (found == record_.stages.end() || found->second.status != StageStatus::done ||
      found->second.key.empty() || !damage(stage).empty())
    return {};
  return found->second.key;
}

void RunFolder::require_whole(const std::string& stage) const {
  const auto found = record_.stages.find(stage);
  if (found == record_.stages.end() || found->second.status != StageStatus::done) return;
  if (damage(stage).empty()) return;
  throw InputError(damage(stage) + " after kappamu " + stage + " wrote it; do that stage again");
}

void RunFolder::require_whole_but(const std::string& folder, const std::string& stage) const {
  const auto found = record_.stages.find(stage);
  if (found == record_.stages.end() || found->second.status != StageStatus::done) return;
  std::vector<OwnedFile> others;
  std::string damage;
  for (const OwnedFile& file : found->second.files) {
    if (!file.path.starts_with(folder + "/")) {
      others.push_back(file);
      continue;
    }
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(folder_ / file.path, error);
    if (error) damage = (folder_ / file.path).string() + " is missing";
    if (!error && bytes != file.bytes) damage = (folder_ / file.path).string() + " was changed";
    if (!damage.empty()) break;
  }
  if (damage.empty()) damage = damage_among(others);
  if (damage.empty()) return;
  throw InputError(damage + " after kappamu " + stage + " wrote it; do that stage again");
}

bool RunFolder::run(const Stage& stage, Progress& progress, const Work& work,
                    const KnownFingerprints& written) {
  const bool keeps = results_ == Results::kept;
  if (keeps && done_key(stage.name) == stage.key) return false;
  if (const auto former = record_.stages.find(stage.name);
      keeps && former != record_.stages.end() && former->second.status == StageStatus::done &&
      former->second.key == stage.key)
    progress.warn(damage(stage.name) + " after kappamu wrote it: " + stage.name + " is done again");

  // 1. Either continue an interrupted attempt, or begin anew; former outputs stay meanwhile.
  require_room(stage);
  StagedFiles files = files_of(stage.name);
  files.begin(stage.key, keeps ? stage.interrupted : Interrupted::removed);

  // 2. Work; a failure leaves the stage "started".
  RecordingProgress recording(progress);
  const Stopwatch watch;
  try {
    work(files.partial(), recording);
  } catch (...) {
    if (stage.interrupted == Interrupted::removed || is_without_files(files.partial())) {
      files.discard();
    }
    throw;
  }

  // 3. Commit.
  StageRecord& entry = record_.stages.at(stage.name);
  entry.seconds = watch.seconds();
  entry.warnings = recording.warnings();
  files.commit(written);
  damage_.erase(stage.name);
  return true;
}

}  // namespace kappamu::pipeline
