#include "app/mpi/path_files.h"

#include <nlohmann/json.hpp>

#include "app/mpi/npy_parts.h"
#include "core/error.h"
#include "forward/distributed/together.h"
#include "io/atomic_file.h"
#include "io/read_file.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using forward::distributed::on_first;
using forward::distributed::shared;
using inverse::distributed::PathState;
using Json = nlohmann::json;

/// [κ, μ][z][y][x], this rank's voxels of both.
Part part_of(const forward::distributed::BlockPieces& pieces) {
  Part part = within(volume_part(pieces.whole().shape, pieces.owned()), 0, 2);
  part.count.front() = 2;
  return part;
}

Json to_json(const PathState& state) {
  const inverse::FitReport& report = state.report;
  Json history = Json::array();
  for (const inverse::StepRecord& r : report.history) {
    history.push_back({r.weight, r.step, r.solves.forward, r.solves.adjoint, r.objective,
                       r.chi2_per_value, r.roughness, r.seconds});
  }
  return {{"weight", state.weight},
          {"seconds", state.seconds},
          {"homogeneous",
           {report.homogeneous_kappa, report.homogeneous_mu, report.homogeneous_log_residual}},
          {"model", report.model.reason},
          {"warnings", report.warnings},
          {"history", history}};
}

PathState from_json(const Json& json) {
  PathState state;
  state.weight = json.at("weight").get<double>();
  state.seconds = json.at("seconds").get<double>();
  inverse::FitReport& report = state.report;
  report.homogeneous_kappa = json.at("homogeneous").at(0).get<double>();
  report.homogeneous_mu = json.at("homogeneous").at(1).get<double>();
  report.homogeneous_log_residual = json.at("homogeneous").at(2).get<double>();
  report.model.model = inverse::Model::volume;
  report.model.reason = json.at("model").get<std::string>();
  report.warnings = json.at("warnings").get<std::vector<std::string>>();
  for (const Json& r : json.at("history")) {
    inverse::StepRecord& step = report.history.emplace_back();
    step.weight = r.at(0).get<double>();
    step.step = r.at(1).get<int>();
    step.solves.forward = r.at(2).get<int>();
    step.solves.adjoint = r.at(3).get<int>();
    step.objective = r.at(4).get<double>();
    step.chi2_per_value = r.at(5).get<double>();
    step.roughness = r.at(6).get<double>();
    step.seconds = r.at(7).get<double>();
  }
  return state;
}

}  // namespace

void PathFiles::save(const PathState& state) const {
  const std::size_t steps = state.report.history.size();
  write_part(pieces_.comm(), array(steps), part_of(pieces_), std::span<const double>(state.own));
  on_first(pieces_.comm(), [&] {
    Json json = to_json(state);
    json["array"] = array(steps).filename().string();
    io::write_text_atomically(json_file(), json.dump());
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(name_ + "_") && name.ends_with(".npy") && name != json["array"]) {
        fs::remove(entry.path());
      }
    }
  });
}

std::optional<PathState> PathFiles::load() const {
  std::string text;
  on_first(pieces_.comm(), [&] {
    if (fs::exists(json_file())) text = io::read_text(json_file());
  });
  text = shared(pieces_.comm(), text);
  if (text.empty()) return std::nullopt;
  try {
    const Json json = Json::parse(text);
    PathState state = from_json(json);
    state.own =
        read_part(pieces_.comm(), folder_ / json.at("array").get<std::string>(), part_of(pieces_));
    return state;
  } catch (const Json::exception&) {
    throw InputError(json_file().string() +
                     ": not a checkpoint as kappamu-mpi writes it; remove the folder and start "
                     "again");
  }
}

void PathFiles::remove() const {
  on_first(pieces_.comm(), [&] {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name == name_ + ".json" || (name.starts_with(name_ + "_") && name.ends_with(".npy"))) {
        files.push_back(entry.path());
      }
    }
    for (const fs::path& file : files) fs::remove(file);
  });
}

}  // namespace kappamu::app::mpi
