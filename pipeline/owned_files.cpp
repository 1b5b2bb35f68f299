#include "pipeline/owned_files.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/error.h"
#include "core/file_name.h"
#include "core/parallel.h"
#include "io/atomic_file.h"
#include "io/json_whole.h"

namespace kappamu::pipeline {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A symbolic link is something else, wherever it leads.
bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() == fs::file_type::regular;
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() == fs::file_type::directory;
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() != fs::file_type::not_found;
}

[[noreturn]] void fail(const fs::path& path, const std::error_code& error) {
  throw InputError("cannot write " + path.string() + ": " + error.message() +
                       "; check the folder or choose another",
                   {{"out"}});
}

[[noreturn]] void fail_in_the_way(const fs::path& path) {
  throw InputError(path.string() +
                       ": is in the way and nothing that kappamu wrote there; move it elsewhere or "
                       "choose another output folder",
                   {{"out"}});
}

bool lists(const std::vector<OwnedFile>& files, const std::string& path) {
  return std::any_of(files.begin(), files.end(),
                     [&](const OwnedFile& file) { return file.path == path; });
}

}  // namespace

std::vector<OwnedFile> describe_files(const fs::path& root, const std::vector<std::string>& paths,
                                      const KnownFingerprints& known) {
  std::vector<OwnedFile> files(paths.size());
  for_rows(static_cast<int>(paths.size()), [&](int k) {
    const std::string& path = paths[static_cast<std::size_t>(k)];
    OwnedFile& file = files[static_cast<std::size_t>(k)];
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(root / path, error);
    if (error) {
      file.path = path;
    } else {
      const auto found = known.find(path);
      file = {path, bytes, found != known.end() ? found->second : content_fingerprint(root / path)};
    }
  });
  return files;
}

FileState state_of(const fs::path& root, const OwnedFile& file) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(root / file.path, error);
  if (error) return FileState::missing;
  if (bytes != file.bytes) return FileState::changed;
  return content_fingerprint(root / file.path) == file.hash ? FileState::whole : FileState::changed;
}

void require_absent(const fs::path& file) {
  if (!is_there(file)) return;
  throw InputError(file.string() + ": exists already; move it elsewhere or choose another",
                   {{"out"}});
}

json files_to_json(const std::vector<OwnedFile>& files) {
  json list = json::array();
  for (const OwnedFile& file : files) {
    list.push_back({{"path", file.path}, {"bytes", file.bytes}, {"hash", file.hash}});
  }
  return list;
}

std::vector<OwnedFile> files_from_json(const json& list) {
  std::vector<OwnedFile> files;
  for (const json& file : list) {
    files.push_back({file.at("path").get<std::string>(),
                     io::whole<std::uintmax_t>(file.at("bytes")),
                     file.at("hash").get<std::string>()});
    const std::string& path = files.back().path;
    if (!stays_inside(path)) {
      throw InputError("the record of files lists '" + shown_name(path) +
                       "', which is no path inside its folder");
    }
  }
  return files;
}

json claim_to_json(const Claim& claim) {
  const char* status = claim.status == StageStatus::done     ? "done"
                       : claim.status == StageStatus::moving ? "moving"
                                                             : "started";
  json object{{"status", status}, {"key", claim.key}, {"files", files_to_json(claim.files)}};
  if (!claim.next.empty()) object["next"] = files_to_json(claim.next);
  return object;
}

Claim claim_from_json(const json& object) {
  Claim claim;
  const auto status = object.at("status").get<std::string>();
  claim.status = status == "done"     ? StageStatus::done
                 : status == "moving" ? StageStatus::moving
                                      : StageStatus::started;
  claim.key = object.at("key").get<std::string>();
  claim.files = files_from_json(object.value("files", json::array()));
  claim.next = files_from_json(object.value("next", json::array()));
  return claim;
}

StagedFiles::StagedFiles(fs::path root, std::string name, Former former, Claim& claim,
                         std::function<void()> save)
    : root_(std::move(root)),
      name_(std::move(name)),
      former_(former),
      claim_(claim),
      save_(std::move(save)) {}

bool StagedFiles::owns(const std::string& path) const {
  return lists(claim_.files, path) || lists(claim_.next, path);
}

void StagedFiles::require_own(const fs::path& file) const {
  if (!is_file(file) || !owns(file.lexically_relative(root_).generic_string())) {
    fail_in_the_way(file);
  }
}

void StagedFiles::require_room(const std::vector<std::string>& outputs, Changed changed) const {
  const bool begun = claim_.status == StageStatus::started || claim_.status == StageStatus::moving;
  if (is_there(partial()) && !(begun && is_folder(partial()))) fail_in_the_way(partial());
  for (const std::string& name : outputs) {
    const fs::path output = root_ / name;
    if (!is_folder(output)) {
      if (is_there(output)) require_own(output);
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(output)) {
      if (!is_folder(entry.path())) require_own(entry.path());
    }
  }
  if (changed == Changed::replaced) return;
  for (const OwnedFile& file : claim_.files) {
    const fs::path path = root_ / file.path;
    if (is_file(path) && state_of(root_, file) == FileState::changed) {
      throw InputError(path.string() +
                           ": was changed after kappamu wrote it and would be replaced; move it "
                           "elsewhere or choose another output folder",
                       {{"out"}});
    }
  }
}

void StagedFiles::begin(const std::string& key, Interrupted interrupted) {
  const bool continues = interrupted == Interrupted::continued &&
                         claim_.status == StageStatus::started && claim_.key == key;
  // While the record still tells that it is ours.
  if (!continues) discard();
  claim_.status = StageStatus::started;
  claim_.key = key;
  save_();
  std::error_code error;
  fs::create_directories(partial(), error);
  if (error) fail(partial(), error);
  if (continues) io::remove_temporaries(partial());
}

void StagedFiles::discard() {
  std::error_code error;
  fs::remove_all(partial(), error);
  if (error) fail(partial(), error);
}

void StagedFiles::commit(const KnownFingerprints& known) {
  std::vector<std::string> next;
  for (const auto& entry : fs::recursive_directory_iterator(partial())) {
    const fs::path relative = entry.path().lexically_relative(partial());
    const fs::path target = root_ / relative;
    if (is_folder(entry.path())) {
      if (is_there(target) && !is_folder(target)) fail_in_the_way(target);
      continue;
    }
    if (is_there(target)) require_own(target);
    next.push_back(relative.generic_string());
  }
  std::sort(next.begin(), next.end());
  claim_.next = describe_files(partial(), next, known);
  claim_.status = StageStatus::moving;
  save_();
  move();
}

void StagedFiles::recover() {
  if (claim_.status != StageStatus::moving) return;
  const bool complete =
      std::all_of(claim_.next.begin(), claim_.next.end(), [&](const OwnedFile& file) {
        return is_file(partial() / file.path) || is_file(root_ / file.path);
      });
  if (complete) return move();
  // Someone took files away: what is left stays ours, and is made again.
  for (OwnedFile& file : claim_.next) {
    if (!lists(claim_.files, file.path)) claim_.files.push_back(std::move(file));
  }
  claim_.next.clear();
  claim_.key.clear();
  claim_.status = StageStatus::started;
  save_();
}

void StagedFiles::move() {
  std::error_code error;
  if (is_folder(partial())) {
    for (const auto& entry : fs::recursive_directory_iterator(partial())) {
      if (!is_folder(entry.path())) continue;
      const fs::path target = root_ / entry.path().lexically_relative(partial());
      fs::create_directories(target, error);
      if (error) fail(target, error);
    }
  }
  for (const OwnedFile& file : claim_.next) {
    const fs::path target = root_ / file.path;
    if (!is_file(partial() / file.path)) continue;  // moved before
    if (is_there(target)) require_own(target);
    fs::rename(partial() / file.path, target, error);
    if (error) fail(target, error);
  }
  std::vector<OwnedFile> files = claim_.next;
  for (const OwnedFile& file : claim_.files) {
    if (lists(claim_.next, file.path)) continue;
    if (former_ == Former::kept) {
      files.push_back(file);
      continue;
    }
    const fs::path path = root_ / file.path;
    if (is_file(path)) fs::remove(path, error);
    // Folders that are empty now; others hold something and stay.
    for (fs::path folder = path.parent_path(); folder != root_; folder = folder.parent_path()) {
      if (!is_folder(folder) || !fs::remove(folder, error)) break;
    }
  }
  discard();
  claim_.files = std::move(files);
  claim_.next.clear();
  claim_.status = StageStatus::done;
  save_();
}

}  // namespace kappamu::pipeline
