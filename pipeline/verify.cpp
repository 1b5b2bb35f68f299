#include "pipeline/verify.h"

#include <algorithm>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "io/read_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/run_record.h"

namespace kappamu::pipeline {

namespace {

namespace fs = std::filesystem;
using What = Finding::What;

/// Another program's run.json is none.
bool has_record(const fs::path& folder) {
  for (const auto& [name, format] :
       {std::pair{"run.json", "kappamu-run"}, std::pair{files_record_name, "kappamu-files"}}) {
    const fs::path file = folder / name;
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored) &&
        io::read_text(file).find(format) != std::string::npos) {
      return true;
    }
  }
  return false;
}

/// The claims of both records, with the names of stages and commands.
std::vector<std::pair<std::string, Claim>> claims_in(const fs::path& folder,
                                                     const std::optional<RunRecord>& run) {
  std::vector<std::pair<std::string, Claim>> claims;
  for (auto& [name, claim] : read_files_record(folder)) claims.emplace_back(name, claim);
  if (!run) return claims;
  for (const auto& [name, stage] : run->stages) {
    claims.emplace_back(name, static_cast<const Claim&>(stage));
  }
  return claims;
}

class Walk {
 public:
  Walk(fs::path root, Progress& progress) : root_(std::move(root)), progress_(progress) {}

  void check(const fs::path& folder) {
    const std::optional<RunRecord> run = read_run_record(folder);
    std::set<fs::path> known{folder / "run.json", folder / "run.lock", folder / files_record_name};
    for (const auto& [name, claim] : claims_in(folder, run)) {
      const fs::path partial = folder / (name + ".partial");
      if (claim.status == StageStatus::started || claim.status == StageStatus::moving) {
        // Of bench, which fills its folder bit by bit, there is neither.
        if (!claim.key.empty() || fs::exists(partial)) add(What::unfinished, folder / name);
        known.insert(partial);
      }
      for (const OwnedFile& file : claim.next) known.insert(folder / file.path);
      for (const OwnedFile& file : claim.files) {
        known.insert(folder / file.path);
        // In the middle of a move old and new files lie side by side.
        if (claim.status == StageStatus::moving) continue;
        const FileState state = compare(folder, file);
        if (state == FileState::missing) add(What::missing, folder / file.path);
        if (state == FileState::changed) add(What::changed, folder / file.path);
      }
    }
    if (run) check_inputs(*run);
    find_foreign(folder, known);
  }
  Verification result;

 private:
  void add(What what, const fs::path& path) {
    result.findings.push_back({what, path.lexically_relative(root_).generic_string()});
  }

  FileState compare(const fs::path& folder, const OwnedFile& file) {
    progress_.update("verify", 0.0, file.path);
    ++result.files;
    result.bytes += file.bytes;
    return state_of(folder, file);
  }

  void check_inputs(const RunRecord& run) {
    if (!fs::is_directory(run.input)) {
      result.findings.push_back({What::no_input, run.input.string()});
      return;
    }
    for (const OwnedFile& file : run.inputs) {
      if (file.hash.empty()) continue;  // missing when the run was made
      const FileState state = compare(run.input, file);
      if (state == FileState::whole) continue;
      result.findings.push_back(
          {state == FileState::missing ? What::input_missing : What::input_changed,
           (run.input / file.path).string()});
    }
  }

  void find_foreign(const fs::path& folder, const std::set<fs::path>& known) {
    for (fs::recursive_directory_iterator entry(folder), end; entry != end; ++entry) {
      if (known.contains(entry->path())) {
        entry.disable_recursion_pending();
      } else if (entry->is_symlink() || !entry->is_directory()) {  // a link may lead round
        add(What::foreign, entry->path());
      } else if (has_record(entry->path())) {
        entry.disable_recursion_pending();
        nested_.push_back(entry->path());
      }
    }
    while (!nested_.empty()) {
      const fs::path next = nested_.back();
      nested_.pop_back();
      check(next);
    }
  }

  fs::path root_;
  Progress& progress_;
  std::vector<fs::path> nested_;
};

}  // namespace

std::string to_string(What what) {
  switch (what) {
    case What::missing:
      return "missing";
    case What::changed:
      return "changed";
    case What::input_missing:
      return "input missing";
    case What::input_changed:
      return "input changed";
    case What::unfinished:
      return "unfinished";
    case What::foreign:
      return "foreign";
    case What::no_input:
      return "no input";
  }
  return "";
}

std::size_t Verification::damaged() const {
  return static_cast<std::size_t>(std::count_if(findings.begin(), findings.end(),
                                                [](const Finding& f) { return f.is_damage(); }));
}

Verification verify_folder(const fs::path& folder, Progress& progress) {
  const fs::path path = canonical_path(folder);
  if (!fs::exists(path / "run.json") && !fs::exists(path / files_record_name)) {
    throw InputError(folder.string() +
                     (fs::is_directory(path) ? ": has neither run.json nor kappamu-files.json"
                                             : ": no such folder") +
                     "; give a folder that kappamu filled");
  }
  Walk walk(path, progress);
  walk.check(path);
  std::stable_sort(walk.result.findings.begin(), walk.result.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.what < b.what; });
  return std::move(walk.result);
}

void require_as_written(const fs::path& path) {
  const fs::path whole = canonical_path(path);
  fs::path folder = whole;
  while (!has_record(folder)) {
    if (folder == folder.parent_path()) return;
    folder = folder.parent_path();
  }
  const std::string inside =
      whole == folder ? "" : whole.lexically_relative(folder).generic_string();
  for (const auto& [name, claim] : claims_in(folder, read_run_record(folder))) {
    if (claim.status == StageStatus::moving) continue;
    for (const OwnedFile& file : claim.files) {
      const bool is_read =
          inside.empty() || file.path == inside || file.path.starts_with(inside + "/");
      if (!is_read) continue;
      const FileState state = state_of(folder, file);
      if (state == FileState::whole) continue;
      throw InputError((folder / file.path).string() +
                       (state == FileState::missing ? " is missing" : " was changed") +
                       " after kappamu " + name +
                       " wrote it; bring it back or make it again (`kappamu verify` lists all)");
    }
  }
}

void require_as_written(const std::vector<fs::path>& paths) {
  for (const fs::path& path : paths) require_as_written(path);
}

}  // namespace kappamu::pipeline
