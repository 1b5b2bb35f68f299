#include "pipeline/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "core/error.h"
#include "io/atomic_file.h"
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

/// Holds the lock until the process ends, however it ends.
int lock_folder(const fs::path& folder) {
  const fs::path file = folder / "run.lock";
  const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0)
    throw InputError("cannot write into " + folder.string() +
                     "; choose an output folder (-o) that you may write to");
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    close(descriptor);
    throw InputError(folder.string() +
                     ": another kappamu is working in this run folder; wait for it to end");
  }
  return descriptor;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw InputError("cannot make " + folder.string() + " (" + error.message() +
                     "); choose another output folder (-o)");
}

}  // namespace

RunFolder::RunFolder(const fs::path& folder, RunRecord::InputKind kind, const fs::path& input,
                     const std::string& input_fingerprint, bool force)
    : folder_(fs::absolute(folder).lexically_normal()), force_(force) {
  make_folder(folder_);
  const int lock = lock_folder(folder_);
  try {
    const std::optional<RunRecord> earlier = read_run_record(folder_);
    if (earlier && earlier->input_fingerprint != input_fingerprint && !force)
      throw InputError(
          folder_.string() + ": holds a run of another input (" + earlier->input.string() +
          ", or what it was before an edit); choose another -o, or --force to replace it");
    if (earlier) record_ = *earlier;
    io::remove_stale_temporaries(folder_);
  } catch (...) {
    close(lock);
    throw;
  }
  lock_ = lock;
  record_.input_kind = kind;
  record_.input = fs::absolute(input).lexically_normal();
  record_.input_fingerprint = input_fingerprint;
  record_.versions = library_versions();
}

RunFolder::~RunFolder() {
  close(lock_);
}

void RunFolder::set_options(std::map<std::string, std::string> options) {
  record_.options = std::move(options);
}

bool RunFolder::is_done(const Stage& stage) const {
  const auto found = record_.stages.find(stage.name);
  return found != record_.stages.end() && found->second.status == StageStatus::done &&
         found->second.key == stage.key &&
         std::all_of(stage.outputs.begin(), stage.outputs.end(),
                     [&](const std::string& name) { return fs::exists(folder_ / name); });
}

bool RunFolder::run(const Stage& stage, Progress& progress,
                    const std::function<void(Progress&)>& work) {
  if (!force_ && is_done(stage)) return false;

  // 1. Either continue an interrupted attempt, or clear what an older one left.
  StageRecord& entry = record_.stages[stage.name];
  const bool continues = !force_ && entry.status == StageStatus::started && entry.key == stage.key;
  if (!continues) entry = {StageStatus::started, stage.key, 0.0, {}};
  write_run_record(record_, folder_);
  if (!continues)
    for (const std::string& name : stage.outputs) fs::remove_all(folder_ / name);

  // 2. Work; a failure leaves the stage "started".
  RecordingProgress recording(progress);
  const auto start = std::chrono::steady_clock::now();
  work(recording);

  // 3. Commit.
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  entry.status = StageStatus::done;
  entry.seconds = elapsed.count();
  entry.warnings = recording.warnings();
  write_run_record(record_, folder_);
  return true;
}

}  // namespace kappamu::pipeline
