#include "pipeline/records/fit_record.h"

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/read_file.h"

namespace kappamu::pipeline {

namespace {

using nlohmann::json;

std::optional<double> optional_number(const json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

}  // namespace

void add_fit_record(const FitRecord& record, nlohmann::ordered_json& object) {
  const auto optional = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  object["status"] = record.status;
  object["grid"] = record.grid;
  object["validation_E"] = optional(record.validation_E);
  object["validation_noise_E"] = optional(record.validation_noise_E);
  object["camera_rms_px"] = optional(record.camera_rms_px);
  object["projector_rms_px"] = optional(record.projector_rms_px);
  object["verdict"] = verdict_json(record.verdict);
}

FitRecord read_fit_record(const std::filesystem::path& fit) {
  const std::filesystem::path file = fit / "fit.json";
  try {
    const json object = json::parse(io::read_text(file));
    return {object.at("status").get<std::string>(),
            object.at("grid").get<std::array<int, 3>>(),
            optional_number(object.at("validation_E")),
            optional_number(object.at("validation_noise_E")),
            optional_number(object.at("camera_rms_px")),
            optional_number(object.at("projector_rms_px")),
            verdict_from_json(object.at("verdict"))};
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": not as this version of kappamu writes it (" + error.what() +
                         "); repeat the fit",
                     {{"force"}});
  }
}

}  // namespace kappamu::pipeline
