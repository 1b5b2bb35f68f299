// Whether the files of a folder that kappamu filled are as it wrote them, by the hashes of its
// records (run.json, kappamu-files.json).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/progress.h"

namespace kappamu::pipeline {

struct Finding {
  enum class What {
    missing,        ///< a file of a record
    changed,        ///< since it was written
    input_missing,  ///< a file that the run was made from
    input_changed,
    unfinished,  ///< a stage or command that was cut short
    foreign,     ///< on no record
    no_input     ///< the folder of the input is not there, so it was not compared
  };
  What what = What::foreign;
  std::string name;  ///< file relative to the folder (inputs: absolute), or stage

  /// Whether results are lost or no longer belong to their input.
  bool is_damage() const { return what <= What::input_changed; }
};
/// "missing", "changed", "input missing", ...
std::string to_string(Finding::What what);

struct Verification {
  std::size_t files = 0;     ///< compared
  std::uintmax_t bytes = 0;  ///< of them, as recorded
  std::vector<Finding> findings;

  std::size_t damaged() const;
};

/// Compares every file of `folder`, and of folders in it that have a record of their own. Throws
/// InputError when it has no record or one that is not as kappamu wrote it.
Verification verify_folder(const std::filesystem::path& folder, Progress& progress);

/// Throws InputError naming the first file at or below `path` that a record in `path` or in a
/// folder around it lists otherwise: for what reads results of an earlier command.
void require_as_written(const std::filesystem::path& path);
void require_as_written(const std::vector<std::filesystem::path>& paths);

}  // namespace kappamu::pipeline
