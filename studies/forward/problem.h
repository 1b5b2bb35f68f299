// A problem whose solution is known to more digits than any method under test will give: what true
// errors are measured against.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "forward/grid/grid_solver.h"
#include "tests/cases/media.h"

namespace kappamu::studies {

struct ProblemSpec {
  std::string name;  ///< "headline", ...
  GridShape shape;
  test_cases::MediumSpec medium;
  int patterns = 16;
  /// φ* is found for the first so many patterns, and errors are those of these: enough of them
  /// where double-precision batches of all would not fit into memory. None: there are no errors.
  int compared = 16;
};

struct Errors {
  double phi = 0.0;  ///< ‖φ − φ*‖₂/‖φ*‖₂ over all voxels, of the worst pattern compared
  double maps = 0.0;  ///< the same of the exitance of all six faces together
};

class Problem {
 public:
  /// Solves for φ* in double by the device's multigrid to a residual of 1e-13, then once more from
  /// there: `truth_error()` is by how much the second solve moved it.
  Problem(ProblemSpec spec, const std::string& device);

  const ProblemSpec& spec() const { return spec_; }
  const forward::GridSetup& setup() const { return setup_; }
  const Medium& medium() const { return medium_; }
  const std::vector<double>& irradiance() const { return irradiance_; }  ///< [pattern][v][u]
  std::vector<double> irradiance(int patterns) const;                    ///< of the first ones
  /// b [pattern][z][y][x] of the first `patterns` ≤ compared.
  std::vector<double> right_hand_sides(int patterns) const;
  double truth_error() const { return truth_error_; }
  const BoundaryConstants& constants() const { return solver_->constants(); }

  /// φ holds `patterns` volumes [pattern][z][y][x]; the first min(patterns, compared) are compared.
  Errors errors_of(const std::vector<double>& phi, int patterns) const;
  /// Error of exitance maps in order of all_faces, each [pattern][v][u].
  double map_error(const std::array<std::vector<double>, 6>& maps, int patterns) const;

 private:
  std::array<std::vector<double>, 6> maps_of(const std::vector<double>& phi, int patterns) const;

  ProblemSpec spec_;
  forward::GridSetup setup_;
  Medium medium_;
  std::vector<double> irradiance_;
  std::unique_ptr<forward::GridSolver> solver_;  ///< double; none where nothing is compared
  std::vector<double> phi_;                      ///< φ*, compared patterns
  std::array<std::vector<double>, 6> maps_;
  double truth_error_ = 0.0;
};

/// The matrix (A φ)_i = d_i φ_i − Σ_j G_ij φ_j as arrays [z][y][x]: conductances towards +x, +y, +z
/// (0 at the last cell) and the diagonal. What is handed to the peers.
struct AssembledMatrix {
  std::array<std::vector<double>, 3> link;
  std::vector<double> diagonal;
};
AssembledMatrix assemble(const forward::GridSetup& setup, const BoundaryConstants& constants,
                         const Medium& medium);

}  // namespace kappamu::studies
