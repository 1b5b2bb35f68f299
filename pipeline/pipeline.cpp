#include "pipeline/pipeline.h"

#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "capture/session/session_files.h"
#include "core/error.h"
#include "pipeline/records/fingerprint.h"
#include "pipeline/records/fit_options.h"
#include "pipeline/records/hdr_options.h"
#include "pipeline/stages/calibrate_stage.h"
#include "pipeline/stages/export_stage.h"
#include "pipeline/stages/merge_stage.h"

namespace kappamu::pipeline {

namespace fs = std::filesystem;

struct Pipeline::Input {
  RunRecord::InputKind kind = RunRecord::InputKind::session;
  fs::path folder;
  std::vector<OwnedFile> files;  ///< session.json or measurements.json first
  std::optional<capture::Session> session;
};

namespace {

std::vector<std::string> each_once(const std::vector<std::string>& names) {
  std::vector<std::string> all;
  std::set<std::string> seen;
  for (const std::string& name : names)
    if (seen.insert(name).second) all.push_back(name);
  return all;
}

/// Of this program and of all contents of the input.
std::string fingerprint_of(const std::vector<OwnedFile>& files) {
  Fingerprint result;
  result.add(program_fingerprint());
  for (const OwnedFile& file : files) result.add(file.path).add(file.hash);
  return result.text();
}

}  // namespace

Pipeline::Input Pipeline::open_input(const fs::path& folder, const fs::path& run,
                                     const Permissions& permissions) {
  Input input;
  input.folder = folder;
  if (fs::exists(folder / "session.json")) {
    input.session = capture::read_session(folder);
    if (permissions.links == capture::Links::within) capture::require_files_inside(*input.session);
    require_apart(run, {folder});  // before the frames are read for their hashes
    std::vector<std::string> names = capture::named_files(*input.session);
    names.insert(names.begin(), "session.json");
    input.files = describe_files(folder, each_once(names));
    return input;
  }
  if (fs::exists(folder / "measurements.json")) {
    input.kind = RunRecord::InputKind::measurements;
    require_apart(run, {folder});
    input.files = describe_files(folder, measurement_files(folder));
    return input;
  }
  throw InputError(folder.string() +
                   (fs::is_directory(folder) ? ": has neither session.json nor measurements.json"
                                             : ": no such folder") +
                   "; give a capture session or a folder of surface measurements "
                   "(docs/formats.md)");
}

Pipeline::Pipeline(const fs::path& input, const fs::path& run, const Permissions& permissions)
    : Pipeline(open_input(input, run, permissions), run, permissions) {}

Pipeline::Pipeline(Input input, const fs::path& run, const Permissions& permissions)
    : session_(std::move(input.session)),
      fingerprint_(fingerprint_of(input.files)),
      folder_(run, input.kind, input.folder, input.files.front().hash,
              permissions.replace_other_run ? Results::replaced : Results::kept) {
  folder_.set_inputs(std::move(input.files));
}

const capture::Session& Pipeline::require_session() const {
  if (session_) return *session_;
  throw InputError((folder_.record().input / "session.json").string() +
                   ": no such file; calibrate and merge need a capture session, surface "
                   "measurements go to `kappamu run` or `kappamu fit`");
}

void Pipeline::set_hdr_options(const capture::MergeOptions& options) {
  hdr_ = options;
  std::map<std::string, std::string> recorded = folder_.record().options;
  for (const auto& [name, value] : options_by_name(options)) recorded[name] = value;
  folder_.set_options(std::move(recorded));
}

RunFolder::Stage Pipeline::calibrate_stage() const {
  return {"calibrate",
          Fingerprint().add("calibrate").add(fingerprint_).add(options_text(hdr_)).text(),
          {"calibration"}};
}

RunFolder::Stage Pipeline::merge_stage() const {
  const std::optional<std::string> calibration = folder_.done_key("calibrate");
  return {"merge",
          Fingerprint()
              .add("merge")
              .add(fingerprint_)
              .add(options_text(hdr_))
              .add(calibration ? "measured by " + *calibration : "hdr")
              .text(),
          {"hdr", "measurements", "measurements_validate"},
          Interrupted::continued};
}

void Pipeline::require_room() {
  std::vector<RunFolder::Stage> stages{
      {"fit", "", {"fit"}}, {"export", "", {"export"}}, {"report", "", {"report.html"}}};
  if (session_) stages.insert(stages.begin(), {calibrate_stage(), merge_stage()});
  for (const RunFolder::Stage& stage : stages) folder_.require_room(stage);
}

bool Pipeline::calibrate(Progress& progress) {
  const capture::Session& session = require_session();
  return folder_.run(calibrate_stage(), progress, [&](const fs::path& output, Progress& listener) {
    run_calibrate_stage(session, hdr_, output / "calibration", listener);
  });
}

bool Pipeline::merge(Progress& progress) {
  const capture::Session& session = require_session();
  folder_.require_whole("calibrate");
  std::optional<fs::path> calibration;
  if (folder_.done_key("calibrate")) calibration = folder_.path() / "calibration";
  KnownFingerprints written;
  const auto work = [&](const fs::path& output, Progress& listener) {
    shared_error_ = run_merge_stage(session, hdr_, calibration, output, listener, {}, &written);
  };
  return folder_.run(merge_stage(), progress, work, written);
}

RunFolder::Stage Pipeline::stage_after(const RunFolder::Stage& earlier, const std::string& name,
                                       const std::string& options,
                                       std::vector<std::string> outputs) {
  return {name, Fingerprint().add(name).add(earlier.key).add(options).text(), std::move(outputs)};
}

bool Pipeline::fit(const FitStageOptions& options, Progress& progress) {
  const RunFolder::Stage input = session_ ? merge_stage() : RunFolder::Stage{"", fingerprint_, {}};
  fit_stage_ = stage_after(input, "fit", options_json(options), {"fit"});
  fit_stage_.interrupted = Interrupted::continued;
  const fs::path measurements = session_ ? folder_.path() : folder_.record().input;
  return folder_.run(fit_stage_, progress, [&](const fs::path& output, Progress& listener) {
    const FitSummary summary = run_fit_stage(measurements, output / "fit", options, listener);
    std::map<std::string, double> errors;
    for (std::size_t c = 0; c < summary.validation.size(); ++c) {
      errors[summary.channels[c]] = summary.validation[c].error.E();
    }
    folder_.set_device(summary.device);
    folder_.set_validation_error(std::move(errors));
  });
}

bool Pipeline::export_all(Progress& progress) {
  return folder_.run(stage_after(fit_stage_, "export", "all", {"export"}), progress,
                     [&](const fs::path& output, Progress& listener) {
                       // The fit's own volume may be of any size.
                       export_volumes(folder_.path() / "fit" / "volume.vdb", output / "export",
                                      {"all"}, listener, std::numeric_limits<std::size_t>::max());
                     });
}

bool Pipeline::report(const std::function<void(const fs::path& run, const fs::path& file)>& write,
                      Progress& progress) {
  return folder_.run(stage_after(fit_stage_, "report", "", {"report.html"}), progress,
                     [&](const fs::path& output, Progress& listener) {
                       listener.update("report", 0.0, "");
                       write(folder_.path(), output / "report.html");
                       listener.update("report", 1.0, "");
                     });
}

}  // namespace kappamu::pipeline
