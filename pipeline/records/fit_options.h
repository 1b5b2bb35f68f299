// The options of a fit: as parsed, as the fit takes them, and as they are recorded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "inverse/fit/fit.h"

namespace kappamu::pipeline {

struct FitStageOptions {
  inverse::FitOptions fit;
  std::vector<std::string> channels;  ///< names of those to fit; empty = all
  /// Patterns kept out of the fit: "auto", "none", a count or a list (pipeline/stages/hold_out.h).
  std::string hold_out = "auto";
  /// Measurements under light of their own to judge the fit by; found beside the input when not
  /// given.
  std::optional<std::filesystem::path> validate;
  bool restart = false;  ///< ignore checkpoints
  /// Folder of a finished fit whose volumes are the start (pipeline/stages/continuation.h).
  std::optional<std::filesystem::path> continue_from;
};

/// Adjoint solves the commands spend on where the data constrain the volume.
inline constexpr int sensitivity_probes = 8;

/// Samples the commands spend on the volumes' uncertainty.
inline constexpr int uncertainty_samples = 2;

/// As parsed; resolve() makes options of it.
struct FitArguments {
  std::string model = "auto";
  std::string optimiser = "lbfgs";
  std::string convention = "physical";
  std::string precision = "single";
  std::string loss = "gaussian";
  std::string regulariser = "h1";
  bool no_grid_correction = false;
  FitStageOptions stage;
};

/// Every option that the volumes depend on, by name: one flat JSON object, equal for equal options.
/// The key of the fit stage, run.json, fit.json and the report are all made of it.
std::string options_json(const FitStageOptions& options);

/// The same by name, each value as JSON writes it.
std::map<std::string, std::string> options_by_name(const FitStageOptions& options);

/// Options of the fit stage. Throws InputError naming option, value and bound.
FitStageOptions resolve(const FitArguments& arguments, const std::string& device,
                        std::uint64_t seed);

}  // namespace kappamu::pipeline
