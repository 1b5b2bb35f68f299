#include "pipeline/output_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/read_file.h"
#include "pipeline/records/sealed_json.h"

namespace kappamu::pipeline {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* format_name = "kappamu-files";

void write_record(const fs::path& folder, const std::map<std::string, Claim>& claims) {
  json commands = json::object();
  for (const auto& [command, claim] : claims) commands[command] = claim_to_json(claim);
  const json object{{"format", format_name}, {"version", 1}, {"commands", commands}};
  io::write_text_atomically(folder / files_record_name, sealed_text(object, 1));
}

}  // namespace

std::map<std::string, Claim> read_files_record(const fs::path& folder) {
  const fs::path path = folder / files_record_name;
  std::map<std::string, Claim> claims;
  if (!fs::exists(path)) return claims;
  try {
    const json object = json::parse(io::read_text(path));
    if (object.at("format") == format_name && object.at("version") == 1 && is_sealed(object)) {
      for (const auto& [command, claim] : object.at("commands").items()) {
        claims[command] = claim_from_json(claim);
      }
      return claims;
    }
  } catch (const json::exception&) {
  }
  throw InputError(
      path.string() +
          ": not a list of files as kappamu wrote it; remove it or choose another output "
          "folder",
      {{"out"}});
}

fs::path canonical_path(const fs::path& path) {
  // The second pass resolves links that ".." behind a missing folder uncovered in the first.
  std::error_code error;
  for (fs::path result = fs::absolute(path);;) {
    fs::path next = fs::weakly_canonical(result, error);
    if (error) return result.lexically_normal();
    if (next == result) {
      if (!next.has_filename() && next.has_parent_path() && next != next.root_path()) {
        return next.parent_path();
      }
      return next;
    }
    result = std::move(next);
  }
}

bool holds(const fs::path& folder, const fs::path& path) {
  const fs::path outer = canonical_path(folder);
  std::error_code error;
  for (fs::path part = canonical_path(path);; part = part.parent_path()) {
    if (part == outer || fs::equivalent(part, outer, error)) return true;
    if (part == part.parent_path()) return false;
  }
}

void require_apart(const fs::path& folder, const std::vector<fs::path>& inputs) {
  for (const fs::path& input : inputs) {
    if (input.empty()) continue;
    const bool around = holds(folder, input);
    const bool within = holds(input, folder);
    if (!around && !within) continue;
    const char* how = around && within ? "is" : around ? "contains" : "lies in";
    throw InputError(folder.string() + ": the output folder " + how + " " + input.string() +
                         ", which is read; choose one apart from it",
                     {{"out"}});
  }
}

void make_output_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw InputError("cannot make " + folder.string() + " (" + error.message() +
                         "); choose another output folder",
                     {{"out"}});
  }
}

void remove_stale_record(const fs::path& record, const std::string& format) {
  const std::string start = "." + record.stem().string() + ".partial-";
  std::error_code error;
  std::vector<fs::path> stale;
  for (const auto& entry : fs::directory_iterator(record.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(start) || !io::is_temporary_name(name)) continue;
    if (entry.symlink_status(error).type() != fs::file_type::regular) continue;
    // Written at once, so it is empty or whole; anything else of such a name is not ours.
    if (entry.file_size() > 0) {
      const json object = json::parse(io::read_text(entry.path()), nullptr, false);
      if (!object.is_object() || object.value("format", json()) != format) continue;
    }
    stale.push_back(entry.path());
  }
  for (const fs::path& file : stale) fs::remove(file, error);
}

FolderLock::FolderLock(const fs::path& folder, By by) {
  descriptor_ = by == By::file ? ::open((folder / "run.lock").c_str(),
                                        O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644)
                               : ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) {
    throw InputError(
        "cannot write into " + folder.string() + "; choose an output folder that you may write to",
        {{"out"}});
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(descriptor_);
  throw InputError(folder.string() +
                   ": another kappamu is working in this folder; wait for it to end");
}

FolderLock::~FolderLock() {
  ::close(descriptor_);
}

fs::path OutputFolder::prepared(const fs::path& folder, const std::vector<fs::path>& inputs) {
  require_apart(folder, inputs);
  fs::path path = canonical_path(folder);
  made_ = !fs::exists(path);
  make_output_folder(path);
  return path;
}

OutputFolder::OutputFolder(const fs::path& folder, const std::string& command,
                           const std::vector<fs::path>& inputs,
                           const std::vector<std::string>& outputs, Former former,
                           const std::string& key, Interrupted interrupted)
    : interrupted_(interrupted),
      command_(command),
      folder_(prepared(folder, inputs)),
      lock_(folder_, FolderLock::By::folder),
      claims_(read_files_record(folder_)),
      files_(folder_, command, former, claims_[command],
             [this] { write_record(folder_, claims_); }) {
  remove_stale_record(folder_ / files_record_name, format_name);
  files_.recover();
  files_.require_room(outputs, Changed::refused);
  files_.begin(key, interrupted);
}

void OutputFolder::commit() {
  files_.commit();
  committed_ = true;
}

OutputFolder::~OutputFolder() {
  // Complete, though something was in the way of the move: kept.
  if (committed_ || claims_.at(command_).status == StageStatus::moving) return;
  try {
    if (interrupted_ == Interrupted::continued && !fs::is_empty(partial())) return;
    files_.discard();
    if (!claims_.at(command_).files.empty()) return;
    claims_.erase(command_);
    if (!claims_.empty()) {
      write_record(folder_, claims_);
      return;
    }
    fs::remove(folder_ / files_record_name);
    if (made_) fs::remove(folder_);
  } catch (const std::exception&) {
    // The failure that ends the command is the one to report.
  }
}

fs::path bench_folder(const fs::path& folder, const std::vector<fs::path>& inputs) {
  require_apart(folder, inputs);
  fs::path path = canonical_path(folder);
  make_output_folder(path);
  std::map<std::string, Claim> claims = read_files_record(path);
  if (claims.contains("bench")) return path;
  const fs::directory_iterator first(path);
  if (first != fs::directory_iterator()) {
    throw InputError(
        first->path().string() +
            ": was not written by kappamu-studies, which replaces what its folder holds; "
            "choose an empty folder",
        {{"out"}});
  }
  claims["bench"].status = StageStatus::started;
  write_record(path, claims);
  return path;
}

}  // namespace kappamu::pipeline
