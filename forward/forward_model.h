// One question, many answers: (volume, block, light) → exitance of every face with an error
// estimate. Each forward model answers it through this interface; that is what lets `kappamu
// forward --method` name them and one chart compare them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/grid.h"
#include "core/progress.h"
#include "forward/grid/block_light.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/power_balance.h"

namespace kappamu::forward {

struct ForwardProblem {
  GridSetup setup;
  Medium medium;
  int patterns = 1;
  std::vector<double> irradiance;  ///< [pattern][v][u] on the lit face, before Fresnel
  LightGeometry light{};           ///< where `any_light` of the method says so
};

/// What a caller may ask of a model; each model reads what concerns it.
struct ForwardOptions {
  std::string device = "auto";  ///< as device::choose reads it
  Precision precision = Precision::single_precision;
  SolveOptions solve;                 ///< iterative models
  std::uint64_t seed = 1;             ///< models that draw random numbers
  std::uint64_t photons = 1'000'000;  ///< per pattern, Monte Carlo
  double anisotropy = 0.0;            ///< g of Monte Carlo's phase function; σs = σs'/(1−g)
  double model_tolerance = 0.05;      ///< of `auto`: relative error against transport, 2-norm
  bool fluence = false;               ///< also ForwardResult::fluence, of models with `any_light`
  /// Of Monte Carlo under collimated light: the exitance of their faces is that of a surface which
  /// would send them the same radiance by the P1 law (radiance_per_exitance). All on one axis.
  Cameras cameras{};
};

struct ForwardResult {
  std::string backend;  ///< device and precision, or "reference"
  Termination termination = Termination::failed;
  std::string message;           ///< one sentence: why it stopped
  int iterations = 0;            ///< of the slowest pattern; 0 where the word has no meaning
  double seconds = 0.0;          ///< solving, all patterns
  double setup_seconds = 0.0;    ///< what has to be redone when κ and μ change
  std::vector<double> residual;  ///< relative, of each pattern's own equations; empty: none
  std::array<std::vector<double>, 6> exitance;  ///< [pattern][v][u], in order of all_faces
  std::array<std::vector<double>, 6>
      standard_error;  ///< of `exitance`, same shapes; empty: the model draws no random numbers
  /// Fluence rate φ of scattered light, and of all light of a point, [pattern][z][y][x], means
  /// over the voxels, in the unit of the irradiance; empty unless asked for.
  std::vector<double> fluence;
  std::vector<double> fluence_error;  ///< standard error of `fluence`; empty as standard_error is
  std::uint64_t photons = 0;          ///< walked per pattern
  std::vector<PowerBalance> balance;  ///< one per pattern
  std::vector<std::string> warnings;  ///< sentences the caller must show
};

class ForwardModel {
 public:
  virtual ~ForwardModel() = default;
  /// Throws InputError where the problem is outside what the model can answer.
  virtual ForwardResult solve(const ForwardProblem& problem, const ForwardOptions& options,
                              Progress& progress) const = 0;
};

struct MethodName {
  std::string name;
  std::string description;  ///< one line, for --help and error messages
  bool transport = false;   ///< needs no diffusion to hold
  bool any_light = false;   ///< takes directions and points, has fluence
};

/// The names `make_forward_model` knows, cheapest to explain first.
const std::vector<MethodName>& forward_methods();

/// Its solve() throws InputError where problem or options ask for what `any_light` denies. Throws
/// InputError listing the names when there is no such method.
std::unique_ptr<ForwardModel> make_forward_model(const std::string& method);

}  // namespace kappamu::forward
