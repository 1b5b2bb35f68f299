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
using forward::distributed::BlockPieces;
using forward::distributed::on_first;
using forward::distributed::shared;
using inverse::distributed::PathState;
using Json = nlohmann::json;

/// [κ, μ][z][y][x], this rank's voxels of both.
Part part_of(const BlockPieces& pieces) {
  Part part = within(volume_part(pieces.whole().shape, pieces.owned()), 0, 2);
  part.count.front() = 2;
  return part;
}

/// Of a coarser grid; null where these pieces are not halved so often.
std::shared_ptr<const BlockPieces> on_level(std::shared_ptr<const BlockPieces> pieces, int level) {
  for (; level > 0 && pieces; --level)
    pieces = pieces->halvings() > 0 ? pieces->coarser() : nullptr;
  return pieces;
}

Json solves_json(const inverse::SolveCount& solves) {
  return {solves.forward, solves.adjoint, solves.refined, solves.tangent, solves.voxel_iterations};
}

inverse::SolveCount solves_from(const Json& json) {
  inverse::SolveCount solves;
  solves.forward = json.at(0).get<int>();
  solves.adjoint = json.at(1).get<int>();
  solves.refined = json.at(2).get<int>();
  solves.tangent = json.at(3).get<int>();
  solves.voxel_iterations = json.at(4).get<double>();
  return solves;
}

Json to_json(const PathState& state) {
  const inverse::FitReport& report = state.report;
  Json history = Json::array();
  for (const inverse::StepRecord& r : report.history) {
    history.push_back({r.level, r.weight, r.step, solves_json(r.solves), r.objective,
                       r.chi2_per_value, r.roughness, r.seconds});
  }
  return {{"level", state.level},
          {"closer", state.closer},
          {"weight", state.weight},
          {"last", state.last},
          {"end", static_cast<int>(state.end)},
          {"last_chi2", state.last_chi2},
          {"last_score", state.last_score},
          {"pairs", state.pairs.size()},
          {"pairs_weight", state.pairs_weight},
          {"seconds", state.seconds},
          {"solves", solves_json(report.solves)},
          {"homogeneous",
           {report.homogeneous_kappa, report.homogeneous_mu, report.homogeneous_log_residual}},
          {"model", report.model.reason},
          {"warnings", report.warnings},
          {"history", history}};
}

PathState from_json(const Json& json) {
  PathState state;
  state.level = json.at("level").get<int>();
  state.closer = json.at("closer").get<bool>();
  state.weight = json.at("weight").get<double>();
  state.last = json.at("last").get<bool>();
  state.end = static_cast<inverse::PathEnd>(json.at("end").get<int>());
  state.last_chi2 = json.at("last_chi2").get<double>();
  state.last_score = json.at("last_score").get<double>();
  state.pairs.resize(json.at("pairs").get<std::size_t>());
  state.pairs_weight = json.at("pairs_weight").get<double>();
  state.seconds = json.at("seconds").get<double>();
  inverse::FitReport& report = state.report;
  report.homogeneous_kappa = json.at("homogeneous").at(0).get<double>();
  report.homogeneous_mu = json.at("homogeneous").at(1).get<double>();
  report.homogeneous_log_residual = json.at("homogeneous").at(2).get<double>();
  report.solves = solves_from(json.at("solves"));
  report.model.model = inverse::Model::volume;
  report.model.reason = json.at("model").get<std::string>();
  report.warnings = json.at("warnings").get<std::vector<std::string>>();
  for (const Json& r : json.at("history")) {
    inverse::StepRecord& step = report.history.emplace_back();
    step.level = r.at(0).get<int>();
    step.weight = r.at(1).get<double>();
    step.step = r.at(2).get<int>();
    step.solves = solves_from(r.at(3));
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
  const auto pieces = on_level(pieces_, state.level);
  std::vector<double> own = state.own.log_kappa;
  own.insert(own.end(), state.own.log_mu.begin(), state.own.log_mu.end());
  write_part(pieces->comm(), array(steps), part_of(*pieces), std::span<const double>(own));
  for (std::size_t k = 0; k < 2 * state.pairs.size(); ++k) {
    const inverse::distributed::FieldPair& pair = state.pairs[k / 2];
    write_part(pieces->comm(), pairs(steps), within(part_of(*pieces), k, 2 * state.pairs.size()),
               std::span<const float>(k % 2 == 0 ? pair.step : pair.change));
  }
  on_first(pieces_->comm(), [&] {
    Json json = to_json(state);
    json["array"] = array(steps).filename().string();
    json["array_of_pairs"] = pairs(steps).filename().string();
    io::write_text_atomically(json_file(), json.dump());
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(name_ + "_") && name.ends_with(".npy") && name != json["array"] &&
          name != json["array_of_pairs"]) {
        fs::remove(entry.path());
      }
    }
  });
}

std::optional<PathState> PathFiles::load() const {
  std::string text;
  on_first(pieces_->comm(), [&] {
    if (fs::exists(json_file())) text = io::read_text(json_file());
  });
  text = shared(pieces_->comm(), text);
  if (text.empty()) return std::nullopt;
  try {
    const Json json = Json::parse(text);
    PathState state = from_json(json);
    const auto pieces = on_level(pieces_, state.level);
    if (!pieces) return std::nullopt;
    const std::vector<double> own =
        read_part(pieces->comm(), folder_ / json.at("array").get<std::string>(), part_of(*pieces));
    const auto half = own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2);
    state.own = {{own.begin(), half}, {half, own.end()}};
    const fs::path of_pairs = folder_ / json.at("array_of_pairs").get<std::string>();
    for (std::size_t k = 0; k < 2 * state.pairs.size(); ++k) {
      const std::vector<double> values =
          read_part(pieces->comm(), of_pairs, within(part_of(*pieces), k, 2 * state.pairs.size()));
      inverse::distributed::FieldPair& pair = state.pairs[k / 2];
      (k % 2 == 0 ? pair.step : pair.change).assign(values.begin(), values.end());
    }
    return state;
  } catch (const Json::exception&) {
    throw InputError(json_file().string() +
                     ": not a checkpoint as kappamu-mpi writes it; remove the folder and start "
                     "again");
  }
}

void PathFiles::remove() const {
  on_first(pieces_->comm(), [&] {
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
