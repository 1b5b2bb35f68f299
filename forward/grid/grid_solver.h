// Grid diffusion on a block, many light patterns at once: the interface both backends implement
// (the serial double reference and OpenCL). What inverse problems see of it is DiffusionOperator
// (grid_operator.cpp).
//
// Discretisation (docs/theory.md): cell-centred finite volumes on cubic voxels of edge h. With G_ij
// the conductance of the face between cells i and j, h·2κ_iκ_j/(κ_i+κ_j), and G_b = h²/(h/(2κ_i) +
// 2A) that of a boundary face (0 on mirror sides),
//     (A φ)_i = Σ_j G_ij (φ_i − φ_j) + Σ_b G_b φ_i + μ_i h³ φ_i = b_i.
// Every equation is a balance of power [mm² · irradiance]. A is symmetric positive definite: it is
// its own adjoint. All irradiances are relative to the rig's white irradiance; φ has the same unit.
//
// Surface arrays are [pattern][v][u] over a face (core/grid.h), volume arrays [z][y][x]; host data
// are double.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/grid.h"
#include "core/optics.h"
#include "forward/operator.h"

namespace kappamu::device {
class Buffer;
class Context;
}  // namespace kappamu::device

namespace kappamu::forward {

struct DeviceBatch;

/// Sums over patterns of products of two fields; what a gradient is assembled from
/// (derivatives.h). Each is a volume [z][y][x].
struct PairProducts {
  std::vector<double> cell;  ///< Σ_m λ_i φ_i
  std::vector<double>
      face_x;  ///< Σ_m (λ_i − λ_j)(φ_i − φ_j), j = i's neighbour towards +x; 0 at the last x
  std::vector<double> face_y;  ///< the same towards +y
  std::vector<double> face_z;  ///< the same towards +z
};

/// δA and δb along a direction of (κ, μ), the same for every pattern. Volumes [z][y][x].
struct EquationsChange {
  std::vector<double> face_x;    ///< δG_ij towards +x [mm]; 0 at the last x
  std::vector<double> face_y;    ///< the same towards +y
  std::vector<double> face_z;    ///< the same towards +z
  std::vector<double> diagonal;  ///< δ(μ h³ + Σ_b G_b) [mm²]
  std::vector<double> source;  ///< δb per irradiance of the voxel's column on the lit face [mm²]
};

/// Medium and gradient of a solver in the memory of its device; pairs of fields as in
/// forward/device_medium.h.
class GridOnDevice {
 public:
  virtual ~GridOnDevice() = default;

  virtual device::Context& context() const = 0;
  virtual void set_medium(const device::Buffer& logs) = 0;
  /// As set.
  virtual CoefficientPair medium() const = 0;
  /// Values of faces are double, [pattern][face][v][u]; `light` is [pattern][v][u].
  virtual void light_source(const device::Buffer& light, BatchField& b) const = 0;
  virtual void exitance(const BatchField& phi, std::span<const Face> seen,
                        const device::Buffer& light, const device::Buffer& out) const = 0;
  /// The sum over the faces.
  virtual void exitance_adjoint(std::span<const Face> seen, const device::Buffer& weights,
                                BatchField& b) const = 0;
  /// Adds what forward::add_gradient() (derivatives.h) makes of the sums of λ and φ.
  virtual void add_gradient(const BatchField& lambda, const DeviceBatch& at,
                            std::span<const Face> seen, const device::Buffer& weights,
                            const device::Buffer& gradient) const = 0;
};

class GridSolver {
 public:
  virtual ~GridSolver() = default;

  virtual const GridSetup& setup() const = 0;
  virtual const BoundaryConstants& constants() const = 0;
  virtual std::string backend()
      const = 0;  ///< "reference" or the OpenCL device's name and precision

  /// Sets κ [mm] and μ [1/mm] and rebuilds the preconditioner. Throws InputError on invalid
  /// coefficients.
  virtual void set_medium(std::span<const double> kappa, std::span<const double> mu) = 0;

  /// A zero field for `patterns` right-hand sides.
  virtual std::unique_ptr<BatchField> make_field(int patterns) const = 0;
  virtual void fill(BatchField& field,
                    std::span<const double> values /* [pattern][z][y][x] */) const = 0;
  virtual void read(const BatchField& field,
                    std::span<double> values /* [pattern][z][y][x] */) const = 0;

  /// b of each pattern for incident irradiance [pattern][v][u] on the lit face, before Fresnel.
  virtual void light_source(std::span<const double> irradiance, BatchField& b) const = 0;

  /// b = (∂ exitance/∂φ)ᵀ weights: the adjoint of exitance() for a face; weights are
  /// [pattern][v][u].
  virtual void exitance_adjoint(Face face, std::span<const double> weights,
                                BatchField& b) const = 0;

  /// y = A φ.
  virtual void apply(const BatchField& phi, BatchField& y) const = 0;

  /// φ, zero so far, from that of a solver on `shape`, voxels of twice the edge: its patterns from
  /// `first` on, linearly between centres. φ stays zero where this solver cannot.
  virtual void interpolate(const BatchField& /*coarse*/, const GridShape& /*shape*/, int /*first*/,
                           BatchField& /*phi*/) const {}

  /// Solves A φ = b; `phi` holds the initial guess on entry (zero, or the last solution).
  virtual SolveReport solve(const BatchField& b, BatchField& phi,
                            const SolveOptions& options) const = 0;

  /// Exitance per area of `face` under φ, [pattern][v][u]: G_b φ_i / h², plus, on the lit face
  /// under the boundary source, what light_source() put there (linear in irradiance, which may be
  /// empty on all other faces).
  virtual void exitance(const BatchField& phi, Face face, std::span<const double> irradiance,
                        std::span<double> out) const = 0;

  virtual PairProducts pair_products(const BatchField& lambda, const BatchField& phi) const = 0;

  /// Σ_m λ_i E_m(u, v) with (u, v) the column of cell i below the lit face: volume [z][y][x], for
  /// ∂b/∂κ, ∂b/∂μ.
  virtual std::vector<double> column_products(const BatchField& lambda,
                                              std::span<const double> irradiance) const = 0;

  /// Σ_i w_i φ_i of each pattern; `weight` is a volume [z][y][x].
  virtual std::vector<double> weighted_sums(const BatchField& phi,
                                            std::span<const double> weight) const = 0;

  /// b = δb − δA φ, the right-hand side of A δφ; `irradiance` [pattern][v][u] on the lit face.
  virtual void change_source(const EquationsChange& change, const BatchField& phi,
                             std::span<const double> irradiance, BatchField& b) const = 0;

  /// Null where medium and gradients go by the host alone.
  virtual GridOnDevice* on_device() { return nullptr; }
};

/// The solver's equations as an inverse problem sees them: light on the setup's lit face, exitance
/// of `seen`.
std::unique_ptr<DiffusionOperator> make_grid_operator(std::unique_ptr<GridSolver> solver,
                                                      const SeenFaces& seen);

/// Serial, double, written for reading.
std::unique_ptr<GridSolver> make_reference_solver(const GridSetup& setup);

/// `device` selects as device::choose does ("auto", "reference", part of a device name). Falls back
/// to the reference, with a warning through `progress`-independent SolverChoice::warning, when the
/// device fails its known-answer test. Throws InputError when no device matches.
struct SolverChoice {
  std::unique_ptr<GridSolver> solver;
  std::string warning;  ///< empty, or one sentence the caller must show
};
SolverChoice make_grid_solver(const GridSetup& setup, const std::string& device,
                              Precision precision = Precision::single_precision);

}  // namespace kappamu::forward
