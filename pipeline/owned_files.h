// Whose a file in an output folder is. A stage (or command) fills the folder NAME.partial beside
// its outputs and moves the files to their places when all are complete; a record in the folder
// (run.json, kappamu-files.json) lists them. Only files on that list are ever replaced or removed,
// and whatever happens the folder ends with the old files or with the new ones.
//
// The order is that of a journal: "started" is recorded before NAME.partial is made, the list of
// new files before the first of them is moved, and a move that was cut short is finished when the
// folder is opened again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "pipeline/records/fingerprint.h"

namespace kappamu::pipeline {

struct OwnedFile {
  std::string path;  ///< relative to the folder of the record, with '/'
  std::uintmax_t bytes = 0;
  std::string hash;  ///< content_fingerprint(); of an input that is missing, empty
};

/// Each root/path as it is now, several read at a time. Of `known` ones the size alone is looked
/// at.
std::vector<OwnedFile> describe_files(const std::filesystem::path& root,
                                      const std::vector<std::string>& paths,
                                      const KnownFingerprints& known = {});

enum class FileState { whole, changed, missing };
/// Compares the contents with what `file` says of them. Throws InputError when it is there and
/// cannot be read.
FileState state_of(const std::filesystem::path& root, const OwnedFile& file);

/// Throws InputError when something of that name is there, a symbolic link too.
void require_absent(const std::filesystem::path& file);

nlohmann::json files_to_json(const std::vector<OwnedFile>& files);
/// Throws nlohmann::json::exception for what is not as written, InputError for a path that leaves
/// the folder.
std::vector<OwnedFile> files_from_json(const nlohmann::json& list);

enum class StageStatus {
  none,     ///< never begun
  started,  ///< begun: NAME.partial is its own, and goes on with the same key
  moving,   ///< complete in NAME.partial, on the way to its place
  done      ///< in its place
};

/// What the record says of one stage.
struct Claim {
  StageStatus status = StageStatus::none;
  std::string key;               ///< fingerprint of everything the files depend on
  std::vector<OwnedFile> files;  ///< in their places
  std::vector<OwnedFile> next;   ///< while moving: those that replace them
};

nlohmann::json claim_to_json(const Claim& claim);
/// Throws as files_from_json().
Claim claim_from_json(const nlohmann::json& object);

/// What becomes of files of the list that a stage does not write again.
enum class Former { removed, kept };

/// What becomes of our own files that somebody changed after they were written.
enum class Changed { replaced, refused };

/// What becomes of an attempt that was interrupted, when one of the same key follows.
enum class Interrupted { removed, continued };

/// The files of one stage while it works.
class StagedFiles {
 public:
  /// `claim` is the record's, which `save` writes down.
  StagedFiles(std::filesystem::path root, std::string name, Former former, Claim& claim,
              std::function<void()> save);

  /// Finishes a move that was cut short.
  void recover();
  /// Throws InputError naming the first file in the way: one at or below `outputs` (names in the
  /// folder) that is not on the list, or is changed where that is refused.
  void require_room(const std::vector<std::string>& outputs, Changed changed) const;
  /// Makes partial(), empty unless an interrupted attempt is continued.
  void begin(const std::string& key, Interrupted interrupted);
  std::filesystem::path partial() const { return root_ / (name_ + ".partial"); }
  /// Moves everything below partial() to its place. Throws InputError, everything left as it is,
  /// when a file is in the way. `known` files are not read again.
  void commit(const KnownFingerprints& known = {});
  /// Removes partial(): of an attempt that failed and has nothing to go on with.
  void discard();

 private:
  bool owns(const std::string& path) const;
  void require_own(const std::filesystem::path& file) const;
  void move();

  std::filesystem::path root_;
  std::string name_;
  Former former_;
  Claim& claim_;
  std::function<void()> save_;
};

}  // namespace kappamu::pipeline
