// run.json: what a run folder was made from, and which of its stages are complete. It is what lets
// `kappamu run` resume, and what the report prints about a run's origin (docs/formats.md).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/owned_files.h"

namespace kappamu::pipeline {

struct StageRecord : Claim {
  double seconds = 0.0;  ///< wall time of the attempt that completed it
  std::vector<std::string> warnings;
};

struct RunRecord {
  enum class InputKind { session, measurements };

  InputKind input_kind = InputKind::session;
  std::filesystem::path input;    ///< absolute folder of the session or the measurements
  std::string input_fingerprint;  ///< of session.json or measurements.json alone
  std::vector<OwnedFile> inputs;  ///< files of the input, when a stage was last done
  std::map<std::string, std::string> options;   ///< in effect, by name
  std::map<std::string, std::string> versions;  ///< library_versions()
  std::string device;                           ///< what the fit ran on; empty before it
  std::map<std::string, double>
      validation_error;                       ///< E under light kept out of the fit, by channel
  std::map<std::string, StageRecord> stages;  ///< by name
};

/// The stages in their order.
inline constexpr const char* stage_names[] = {"calibrate", "merge", "fit", "export", "report"};

/// Reads run/run.json; nothing when there is none. Throws InputError when it is not as kappamu
/// wrote it.
std::optional<RunRecord> read_run_record(const std::filesystem::path& run);

/// Writes run/run.json by rename.
void write_run_record(const RunRecord& record, const std::filesystem::path& run);

}  // namespace kappamu::pipeline
