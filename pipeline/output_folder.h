// The folders that commands write into: kept apart from what they read, locked against a second
// command, and filled as a whole.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "pipeline/owned_files.h"

namespace kappamu::pipeline {

/// An absolute path without symbolic links, "." and "..", as far as it exists.
std::filesystem::path canonical_path(const std::filesystem::path& path);

/// Whether `path` is `folder` or lies in it, however the two are written and linked.
bool holds(const std::filesystem::path& folder, const std::filesystem::path& path);

/// Throws InputError when `folder` is, contains or lies in one of `inputs` (files or folders, which
/// may be missing), however the paths are written and linked: an output folder inside an input, or
/// around it, would mix the two.
void require_apart(const std::filesystem::path& folder,
                   const std::vector<std::filesystem::path>& inputs);

/// Makes the folder if it is missing. Throws InputError when it cannot.
void make_output_folder(const std::filesystem::path& folder);

/// The record of a folder that commands fill without a run.
inline constexpr const char* files_record_name = "kappamu-files.json";
/// Its claims by command; none where there is no record. Throws InputError when it is not as
/// kappamu wrote it.
std::map<std::string, Claim> read_files_record(const std::filesystem::path& folder);

/// Removes what a killed process may have left of writing `record`: temporaries of its name that
/// are empty or hold JSON of that format.
void remove_stale_record(const std::filesystem::path& record, const std::string& format);

/// Held until the process ends, however it ends.
class FolderLock {
 public:
  enum class By {
    file,   ///< run.lock in the folder
    folder  ///< the folder itself, where its file system can
  };
  /// Throws InputError when another process holds it, or nothing can be written there.
  FolderLock(const std::filesystem::path& folder, By by);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_ = -1;
};

/// A folder that one command fills in one go, as those of fit, export, forward and plan. Its record
/// is kappamu-files.json; files that are not on it stay untouched.
class OutputFolder {
 public:
  /// Throws InputError unless `folder` is apart from `inputs` and everything at or below `outputs`
  /// (names in it that `command` will write) is as the same command wrote it earlier. What
  /// attempts may be continued by is their `key`.
  OutputFolder(const std::filesystem::path& folder, const std::string& command,
               const std::vector<std::filesystem::path>& inputs,
               const std::vector<std::string>& outputs, Former former = Former::removed,
               const std::string& key = "", Interrupted interrupted = Interrupted::removed);
  /// Without commit(): leaves what there is to go on with, and otherwise no trace.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// The outputs go here.
  std::filesystem::path partial() const { return files_.partial(); }
  /// And from there to their places.
  void commit();
  const std::filesystem::path& path() const { return folder_; }

 private:
  /// The folder, apart from the inputs and made; whether it was made is for the destructor.
  std::filesystem::path prepared(const std::filesystem::path& folder,
                                 const std::vector<std::filesystem::path>& inputs);

  bool made_ = false;
  Interrupted interrupted_;
  bool committed_ = false;
  std::string command_;
  std::filesystem::path folder_;
  FolderLock lock_;
  std::map<std::string, Claim> claims_;  ///< by command
  StagedFiles files_;
};

/// The folder of `kappamu-studies`, whose sections read what earlier ones wrote: makes it, or
/// throws InputError unless it is empty or bench's already, and apart from `inputs`. Returns its
/// path.
std::filesystem::path bench_folder(const std::filesystem::path& folder,
                                   const std::vector<std::filesystem::path>& inputs = {});

}  // namespace kappamu::pipeline
