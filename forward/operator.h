// The diffusion equation of a medium whose κ and μ vary, as an inverse problem sees it: the
// symmetric positive definite system A φ = b over a MediumSpace and its surface, many light
// patterns at once, with the derivatives of what leaves by what the medium is made of.
//
// `light` and `exitance` are values at places of the surface, light_size() and exitance_size() for
// each pattern: the pixels of a block's lit and seen face, or samples of an object's surface. Light
// is irradiance before Fresnel, relative to the rig's white irradiance; φ and exitance have the
// same unit. Host data are double; a BatchField lives where the operator computes.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "forward/block_setup.h"
#include "forward/medium_space.h"

namespace kappamu::forward {

struct SolveOptions {
  double tolerance = 1e-6;  ///< on ‖b − Aφ‖₂/‖b‖₂ of every pattern
  int max_iterations = 200;
};

enum class Termination { converged, ran_out, failed };

struct SolveReport {
  Termination termination = Termination::failed;
  int iterations = 0;            ///< of the slowest pattern
  std::vector<double> residual;  ///< final relative residual of each pattern
  double seconds = 0.0;
  std::string message;  ///< one sentence: why it stopped
};

enum class Precision { single_precision, double_precision };

/// A batch of M fields, one per pattern.
class BatchField {
 public:
  virtual ~BatchField() = default;
  virtual int patterns() const = 0;
};

/// A batch that was solved: what derivatives are taken at.
struct SolvedBatch {
  const BatchField& phi;
  std::span<const double> light;     ///< [pattern][light_size()]
  std::span<const double> exitance;  ///< of phi, [pattern][exitance_size()]
};

/// The faces of a block that are seen, of one shape. Exitance is [pattern][face][v][u].
struct SeenFaces {
  SeenFaces(Face one) : list{one} {}
  explicit SeenFaces(std::vector<Face> faces) : list(std::move(faces)) {}
  std::vector<Face> list;
};

class DeviceMedium;

class DiffusionOperator {
 public:
  virtual ~DiffusionOperator() = default;

  virtual const MediumSpace& space() const = 0;
  virtual std::size_t light_size() const = 0;
  virtual std::size_t exitance_size() const = 0;
  virtual std::string backend() const = 0;  ///< "reference" or a device's name and precision

  /// κ [mm] and μ [1/mm] of every voxel. Throws InputError on invalid coefficients.
  virtual void set_medium(std::vector<double> kappa, std::vector<double> mu) = 0;

  /// A zero field for `patterns` right-hand sides.
  virtual std::unique_ptr<BatchField> make_field(int patterns) const = 0;

  /// b of each pattern under `light`.
  virtual void load(std::span<const double> light, BatchField& b) const = 0;
  /// (∂b/∂light)ᵀ λ of each pattern.
  virtual void load_transpose(const BatchField& lambda, std::span<double> light) const = 0;

  /// φ, a guess for solve(), from that of an operator on `shape`, voxels of twice the edge: its
  /// patterns from `first` on. φ stays zero where this operator cannot.
  virtual void interpolate(const BatchField& /*coarse*/, const GridShape& /*shape*/, int /*first*/,
                           BatchField& /*phi*/) const {}

  /// Solves A φ = b; `phi` holds the initial guess on entry (zero, or the last solution).
  virtual SolveReport solve(const BatchField& b, BatchField& phi,
                            const SolveOptions& options) const = 0;

  /// Exitance per area under φ, and what the surface reflects of `light` diffusely.
  virtual void exitance(const BatchField& phi, std::span<const double> light,
                        std::span<double> out) const = 0;
  /// b = (∂ exitance/∂φ)ᵀ weights, `weights` [pattern][exitance_size()].
  virtual void exitance_transpose(std::span<const double> weights, BatchField& b) const = 0;

  /// Adds Σ_patterns ∂[λᵀ(b − A φ) + wᵀ M]/∂(log κ, log μ) at fixed φ, λ and w. With
  /// A λ = (∂M/∂φ)ᵀ w it is the gradient of wᵀ M, exact for the discrete model.
  virtual void add_gradient(const SolvedBatch& at, const BatchField& lambda,
                            std::span<const double> weights, CoefficientPair& gradient) const = 0;

  /// Along `direction`: b = δb − δA φ, the right-hand side of A δφ, and δM at fixed φ. The forward
  /// twin of add_gradient(): the two are each other's transpose to the solver's tolerance.
  virtual void linearise(const SolvedBatch& at, const CoefficientPair& direction, BatchField& b,
                         std::span<double> exitance_change) const = 0;

  /// Medium and gradients by the memory of the operator's device (device_medium.h); null where they
  /// go by the host alone.
  virtual DeviceMedium* on_device() { return nullptr; }
};

struct MadeOperator {
  std::unique_ptr<DiffusionOperator> op;
  std::string warning;  ///< empty, or one sentence the caller must show
};

/// Makes the operators of one kind of body, on voxels of any size: the coarser and finer ones of a
/// fit are other calls.
class OperatorFactory {
 public:
  virtual ~OperatorFactory() = default;

  /// `device` selects as device::choose does ("auto", "reference", part of a device name). Throws
  /// InputError when no device matches.
  virtual MadeOperator make(const GridSetup& setup, const SeenFaces& seen,
                            const std::string& device, Precision precision) const = 0;

  /// Bytes for the medium, the work space for `at_once` patterns, and `fields` batches of
  /// `patterns` fields.
  virtual std::size_t memory(const GridSetup& setup, int patterns, int fields, int at_once,
                             Precision precision) const = 0;
};

/// Of blocks (forward/grid): a device that fails its known-answer test is replaced by the serial
/// reference, with a warning.
std::shared_ptr<const OperatorFactory> block_operators();

}  // namespace kappamu::forward
