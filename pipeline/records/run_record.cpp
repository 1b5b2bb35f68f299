#include "pipeline/records/run_record.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/read_file.h"
#include "pipeline/records/sealed_json.h"

namespace kappamu::pipeline {

namespace {

using nlohmann::json;

json to_json(const StageRecord& stage) {
  json object = claim_to_json(stage);
  object["seconds"] = stage.seconds;
  object["warnings"] = stage.warnings;
  return object;
}

StageRecord stage_from_json(const json& object) {
  StageRecord stage;
  static_cast<Claim&>(stage) = claim_from_json(object);
  stage.seconds = object.at("seconds").get<double>();
  stage.warnings = object.at("warnings").get<std::vector<std::string>>();
  return stage;
}

RunRecord from_json(const json& object) {
  RunRecord record;
  record.input_kind = object.at("input_kind").get<std::string>() == "measurements"
                          ? RunRecord::InputKind::measurements
                          : RunRecord::InputKind::session;
  record.input = object.at("input").get<std::string>();
  record.input_fingerprint = object.at("input_fingerprint").get<std::string>();
  record.inputs = files_from_json(object.at("inputs"));
  record.options = object.at("options").get<std::map<std::string, std::string>>();
  record.versions = object.at("versions").get<std::map<std::string, std::string>>();
  record.device = object.at("device").get<std::string>();
  record.validation_error = object.value("validation_E", std::map<std::string, double>{});
  for (const auto& [name, stage] : object.at("stages").items())
    record.stages[name] = stage_from_json(stage);
  return record;
}

}  // namespace

std::optional<RunRecord> read_run_record(const std::filesystem::path& run) {
  const std::filesystem::path path = run / "run.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const json object = json::parse(io::read_text(path));
    if (object.at("format") != "kappamu-run")
      throw InputError(path.string() + ": not a run record; choose another folder");
    if (object.at("version") != 1 || !object.contains("checksum"))
      throw InputError(
          path.string() +
          ": was written by another version of kappamu, whose record this one does not "
          "read; make the run again in another folder");
    RunRecord record = from_json(object);
    if (!is_sealed(object))
      throw InputError(path.string() +
                       ": was changed after kappamu wrote it (its checksum does not fit); bring it "
                       "back or choose another output folder");
    return record;
  } catch (const json::exception&) {
    throw InputError(path.string() +
                     ": damaged or not a run record; remove it or choose another output folder");
  }
}

void write_run_record(const RunRecord& record, const std::filesystem::path& run) {
  json stages = json::object();
  for (const auto& [name, stage] : record.stages) stages[name] = to_json(stage);
  const json object = {
      {"format", "kappamu-run"},
      {"version", 1},
      {"input_kind",
       record.input_kind == RunRecord::InputKind::session ? "session" : "measurements"},
      {"input", record.input.string()},
      {"input_fingerprint", record.input_fingerprint},
      {"inputs", files_to_json(record.inputs)},
      {"options", record.options},
      {"versions", record.versions},
      {"device", record.device},
      {"validation_E", record.validation_error},
      {"stages", stages}};
  io::write_text_atomically(run / "run.json", sealed_text(object, 2));
}

}  // namespace kappamu::pipeline
