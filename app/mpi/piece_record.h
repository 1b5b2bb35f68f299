// fit.json of a fit by pieces, and what validation patterns say of it.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/appearance_error.h"
#include "core/surface_measurements.h"
#include "inverse/distributed/distributed_fit.h"
#include "pipeline/stages/fit_stage.h"
#include "pipeline/stages/validation_choice.h"

namespace kappamu::app::mpi {

/// Validation patterns of one channel.
struct Validation {
  inverse::distributed::PieceScore score;
  std::vector<AppearanceError> error;  ///< of each pattern, all ranks together
};

/// Σ over all ranks by pattern, in exitance; the data's weights stand for their noise. Collective.
std::vector<AppearanceError> errors_of(const inverse::distributed::PieceGrid& data,
                                       const std::vector<double>& prediction);

/// What fit.json says, of all channels in order.
struct PieceRecord {
  const SurfaceMeasurements& header;  ///< the measurements without their arrays
  const pipeline::ValidationChoice& choice;
  const pipeline::FitStageOptions& options;
  std::filesystem::path input;
  std::vector<std::string> names;
  std::vector<inverse::FitReport> reports;
  std::vector<Validation> validation;  ///< by channel; empty without any
  std::vector<std::string> warnings;   ///< beside those of the reports
  double used = 0.0;                   ///< share of the data
  double seconds = 0.0;
  std::vector<double> memory;  ///< at most, by rank [bytes]
};
nlohmann::ordered_json to_json(const PieceRecord& record);

}  // namespace kappamu::app::mpi
