// What earlier commands left: a calibration, the records of a run, a finished fit, a checkpoint.
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "calib/calibration_file.h"
#include "core/error.h"
#include "inverse/checkpoint/checkpoint.h"
#include "inverse/fit/fit_run.h"
#include "io/read_file.h"
#include "pipeline/output_folder.h"
#include "pipeline/records/fit_options.h"
#include "pipeline/records/fit_record.h"
#include "pipeline/records/sealed_json.h"
#include "pipeline/run_folder.h"
#include "pipeline/stages/continuation.h"
#include "pipeline/verify.h"
#include "report/read/run_data.h"
#include "tests/fuzz/targets.h"
#include "tests/report/made_up_run.h"

namespace kappamu::fuzz {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A run folder as small as can be.
const fs::path& small_run() {
  static const fs::path run = [] {
    MadeUpRun options;
    options.nx = 4;
    options.ny = 3;
    options.nz = 2;
    fs::path made = make_run(folder(), options);
    calib::CalibrationResult calibration = calib::load_calibration(made / "calibration");
    calibration.radiometry.bit_depth = 4;
    for (auto& curve : calibration.radiometry.response.linear) curve.resize(16);
    for (auto* views : {&calibration.camera.views, &calibration.projector.views}) {
      for (calib::ViewResidual& view : *views) {
        view.pixels.resize(2);
        view.residuals.resize(2);
      }
    }
    calib::save_calibration(made / "calibration", calibration);
    // What a made-up fit lacks to be gone on from.
    json fit = json::parse(io::read_text(made / "fit" / "fit.json"));
    fit["input"] = "measurements";
    fit["validation"] = {{"patterns", {0}}};
    fit["options"] = json::parse(pipeline::options_json({}));
    for (json& channel : fit["channels"]) {
      channel["weight"] = 1.0;
      channel["homogeneous"] = {{"kappa_mm", 0.3}, {"mu_per_mm", 0.01}, {"log_residual_rms", 0.1}};
      channel["physics"] = {{"name", "diffusion"}, {"reason", ""}};
    }
    write(made / "fit" / "fit.json", bytes_of(fit.dump(1)));
    return made;
  }();
  return run;
}

const Files& calibration_files() {
  static const Files files(small_run() / "calibration",
                           {"camera.yml", "projector.yml", "pose.yml", "response.yml",
                            "radiometry.yml", "calibration.json"});
  return files;
}

const Files& fit_files() {
  static const Files files(small_run(), {"fit/fit.json"});
  return files;
}

/// JSON that a checksum covers gets the right one: it is no guard against intent.
std::string sealed(Bytes bytes) {
  const std::string text(bytes.begin(), bytes.end());
  try {
    const json object = json::parse(text);
    if (object.is_object()) return pipeline::sealed_text(object, 1);
  } catch (const json::exception&) {
  }
  return text;
}

constexpr const char* record_names[] = {"run.json", "kappamu-files.json"};

/// A folder in the middle of things: results, a stage that was moving, somebody's notes.
fs::path fresh_folder() {
  const fs::path made = folder() / "records" / "run";
  fs::remove_all(made);
  for (const char* name : {"fit", "fit.partial/fit", "export.partial", "input"}) {
    fs::create_directories(made / name);
  }
  for (const char* name : {"fit/fit.json", "fit.partial/fit/fit.json", "export.partial/volume.vti",
                           "volume.vti", "notes.txt", "../precious.txt"}) {
    write(made / name, bytes_of("text"));
  }
  return made;
}

json claim(const char* status, json next) {
  json object{{"status", status}, {"key", "k"}, {"files", json::array()}};
  object["files"].push_back({{"path", "volume.vti"}, {"bytes", 4}, {"hash", "0"}});
  if (!next.empty()) object["next"] = json::array({next});
  return object;
}

}  // namespace

void read_calibration(Bytes bytes) {
  const Files& files = calibration_files();
  files.with(bytes, [&] { calib::load_calibration(files.path()); });
}

void seed_calibration(const fs::path& seeds) {
  calibration_files().seed(seeds);
}

void read_run(Bytes bytes) {
  if (bytes.empty()) return;
  const fs::path run = fresh_folder();
  const bool is_run = bytes.front() % 2 == 0;
  const fs::path record = run / record_names[is_run ? 0 : 1];
  write(record, bytes_of(sealed(bytes.subspan(1))));
  Progress progress;
  const auto act = [](const auto& work) {
    try {
      work();
    } catch (const InputError&) {
    }
  };
  act([&] { pipeline::verify_folder(run, progress); });
  act([&] { pipeline::require_as_written(run / "fit"); });
  if (is_run) {
    act([&] { pipeline::RunFolder(run).require_whole("fit"); });
    act([&] {
      pipeline::RunFolder(run).run({"fit", "k", {"fit"}, pipeline::Interrupted::continued},
                                   progress, [](const fs::path&, Progress&) {});
    });
  } else {
    act([&] { pipeline::OutputFolder(run, "export", {}, {"volume.vti"}).commit(); });
  }
  // Whatever a record claims, nothing outside its folder is touched.
  if (io::read_text(run / ".." / "precious.txt") != "text") std::abort();
}

void seed_run(const fs::path& seeds) {
  json record = json::parse(io::read_text(small_run() / "run.json"));
  record["stages"]["fit"] =
      claim("moving", {{"path", "fit/fit.json"}, {"bytes", 4}, {"hash", "0"}});
  record["stages"]["fit"]["seconds"] = 1.0;
  record["stages"]["fit"]["warnings"] = {"a warning"};
  write(seeds / "run.json", bytes_of('\0' + pipeline::sealed_text(record, 1)));
  const json files{
      {"format", "kappamu-files"}, {"version", 1}, {"commands", {{"export", claim("done", {})}}}};
  write(seeds / "kappamu-files.json", bytes_of('\1' + pipeline::sealed_text(files, 1)));
}

void read_fit(Bytes bytes) {
  const Files& files = fit_files();
  files.with(bytes, [&] {
    const pipeline::FinishedFit fit(files.path());
    pipeline::FitStageOptions options;
    fit.set_options(options);
    fit.require_continuable(options, {0});
    pipeline::read_fit_record(fit.folder());
    report::read_fit(files.path());
  });
}

void seed_fit(const fs::path& seeds) {
  fit_files().seed(seeds);
}

void read_checkpoint(Bytes bytes) {
  const std::span<const std::byte> state = std::as_bytes(bytes);
  try {
    inverse::unseal(state, 0);
  } catch (const InputError&) {
  }
  inverse::FitState::from(state);
}

void seed_checkpoint(const fs::path& seeds) {
  inverse::FitState state;
  state.weight = 3000.0;
  state.fields = state.stage.begun = {{0.1, 0.2}, {0.3, 0.4}};
  state.stage.blocks.push_back(Eigen::MatrixXd::Identity(2, 2));
  inverse::OptimiserState& optimiser = state.stage.optimiser;
  optimiser.z = optimiser.gradient = {1.0, 2.0, 3.0, 4.0};
  optimiser.steps.push_back({1.0F, 2.0F, 3.0F, 4.0F});
  optimiser.changes = optimiser.steps;
  optimiser.products.push_back({30.0, {30.0}, {30.0}});
  state.correction = {{0.5}};
  state.report.history.emplace_back();
  state.report.warnings.emplace_back("a warning");
  state.report.model.trials.emplace_back();
  state.simpler.push_back({{0}, {0.1}, {0.2}});
  const std::vector<std::byte> bytes = state.bytes();
  write(seeds / "state", {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace kappamu::fuzz
