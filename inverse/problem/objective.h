// The data term of one channel on one grid, ½ χ²(log κ, log μ) = ½ Σ w (r M − d)² or its robust
// counterpart (data_term.h), and its gradient by the adjoint method: one batched solve for the
// value, one more for the gradient.
//
// r corrects for the grid's own error, and for diffusion's where transport is asked for:
// predictions on a finer grid, or by photons (photon_ratio.h), over predictions on this one, at
// some medium nearby, refreshed when asked. Between refreshes it is constant, or by photons goes as
// it does with even changes of the medium, which value() and its derivatives count.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/names.h"
#include "forward/device_medium.h"
#include "forward/operator.h"
#include "inverse/problem/data_term.h"
#include "inverse/problem/fields.h"
#include "inverse/problem/lit_face.h"
#include "inverse/problem/on_device/device_data.h"
#include "inverse/problem/photon_ratio.h"
#include "inverse/problem/problem.h"

namespace kappamu::inverse {

/// A finer grid for r; its light must be that of the problem.
struct Refinement {
  forward::GridSetup setup;
  std::vector<double> irradiance;          ///< [M][v][u]
  std::optional<PhotonOptions> photons{};  ///< r carries transport's answer too
};

/// r, what its own noise is and how it changes.
struct Correction {
  std::vector<double> ratio;  ///< r where it was made [M][v][u]
  /// Variances of r by photons (PhotonRatio), added to the data's; empty: r has none.
  std::vector<double> variance{};
  std::vector<double> pixel_variance{};
  /// ∂ log r by the means of log κ and log μ over the voxels [M][v][u], and those means where r was
  /// made; empty: r is constant.
  std::array<std::vector<double>, 2> slope{};
  std::array<double, 2> mean{};

  bool operator==(const Correction&) const = default;
};

/// The problem's own grid with every voxel split in 2×2×2.
Refinement refine(const Problem& problem);

/// Coefficients beyond e^±this occur only in a diverging line search.
inline constexpr double max_log_coefficient = 25.0;

/// Where the vectors of a fit's steps live.
enum class VectorPlace {
  automatic,  ///< in the memory of a GPU that has the room, and else the host's
  host,
  device  ///< the operator's, where it has one
};
inline constexpr Names<VectorPlace, 3> vector_place_names{{{"automatic", VectorPlace::automatic},
                                                           {"host", VectorPlace::host},
                                                           {"device", VectorPlace::device}}};

/// Device, precision and tolerances of the solves.
struct Backend {
  std::string device = "auto";
  forward::Precision precision = forward::Precision::single_precision;
  forward::SolveOptions solve{1e-4, 200};
  int batch = 16;                   ///< patterns solved at once
  double refined_tolerance = 1e-4;  ///< of a refined solve's residual
  double refined_memory_mb = 6144;  ///< bound on the fields of a refined solve [MiB]
  /// A fit's solves may leave a share of the data's deviations (as_loose_as_data()).
  bool loose_solves = true;
  /// Makes the operator of every grid; null: forward::block_operators().
  std::shared_ptr<const forward::OperatorFactory> operators{};
  VectorPlace vectors = VectorPlace::automatic;

  forward::MadeOperator make(const forward::GridSetup& setup, const forward::SeenFaces& seen) const;
};

/// Of the logarithms of a medium.
struct LogRange {
  double largest = 0.0;          ///< magnitude; infinite where one is not finite
  std::array<double, 2> mean{};  ///< of log κ and of log μ over the voxels
};

/// Batched solves, each of all patterns, on whatever grid; what the cost of a fit is counted in.
struct SolveCount {
  int forward = 0;
  int adjoint = 0;
  int refined = 0;       ///< forward solves on a finer grid: eight times the voxels
  int tangent = 0;       ///< forward solves for a derivative along a direction
  double photons = 0.0;  ///< of all patterns
  /// Σ voxels × iterations of conjugate gradients over all of these: cost whatever the machine.
  double voxel_iterations = 0.0;

  int total() const { return forward + adjoint + refined + tangent; }
  void add(const SolveCount& other) {
    forward += other.forward;
    adjoint += other.adjoint;
    refined += other.refined;
    tangent += other.tangent;
    photons += other.photons;
    voxel_iterations += other.voxel_iterations;
  }
};

/// Sets φ, zero so far, of the patterns from `first` on to what a solve begins with.
using Guess = std::function<void(int first, forward::BatchField& phi)>;

/// Solves of patterns, at most `batch` at once, from zero or from `guess`; `voxel_iterations`, if
/// given, grows by what they cost.
struct BatchedSolve {
  int batch;
  forward::SolveOptions options;
  double* voxel_iterations = nullptr;
  Guess guess{};
};
/// Of batches from pattern `first` on: load(first, b), then use(first, φ). Throws InputError when
/// the solver fails.
void solve_batches(const forward::DiffusionOperator& op, int patterns, const BatchedSolve& solve,
                   const std::function<void(int first, forward::BatchField& b)>& load,
                   const std::function<void(int first, const forward::BatchField& phi)>& use);

/// Exitance under `light` [M][light_size()].
std::vector<double> solve_exitance(const forward::DiffusionOperator& op,
                                   const std::vector<double>& light, int patterns,
                                   const BatchedSolve& solve);

/// Patterns per batch such that the solver's fields stay below `memory_mb`.
int bounded_batch(const GridShape& shape, int batch, double memory_mb,
                  forward::Precision precision);

class Objective {
 public:
  /// The solver may have fallen back to the serial reference: warning() reports it.
  Objective(Problem problem, Backend backend, DataTermOptions data_term = {});

  /// Its weights count what of r's noise remains in single data.
  const Problem& problem() const { return problem_; }
  const MediumSpace& space() const { return operator_->space(); }
  const std::string& warning() const { return warning_; }
  std::string backend_name() const { return operator_->backend(); }
  const SolveCount& solves() const { return solves_; }

  /// ½ χ² at the fields, or what the data term's options make of it; infinite where the solver does
  /// not converge or coefficients leave the range of floating point. Keeps what gradient() needs.
  double value(const CoefficientPair& fields);

  /// Medium and gradients by the memory of the operator's device; null where there is none.
  forward::DeviceMedium* on_device() const { return operator_->on_device(); }
  /// Whether so many bytes of a fit's vectors belong into that device's memory, by
  /// Backend::vectors or another wish.
  bool belong_on_device(double bytes) const { return belong_on_device(bytes, backend_.vectors); }
  bool belong_on_device(double bytes, VectorPlace place) const;
  /// value() and gradient() of a pair of fields there, [2][z][y][x] in double.
  double value(const device::Buffer& logs, const LogRange& range);
  void gradient(const device::Buffer& by_logs);
  /// What the host knows of value() from then on as if it had been its own: `fields` are those that
  /// it last had from a device.
  void came_from(CoefficientPair fields);

  /// The next value() solves, whatever was solved before: of pieces of one block, all must.
  void forget() { fluence_.clear(); }

  /// Residual that adjoint and tangent solves may leave, relative to their own right-hand sides;
  /// that of Backend::solve at first.
  void set_derivative_tolerance(double tolerance);

  /// At the fields of the last value().
  CoefficientPair gradient();

  /// Σ_m,s probe √w r ∂M/∂(log κ, log μ): one row of the weighted Jacobian's transpose, at the
  /// fields of the last value().
  CoefficientPair jacobian_transpose(const std::vector<double>& probe);

  /// √w r ∂M along `direction`, [M][v][u], at the fields of the last value(): the transpose of
  /// jacobian_transpose(), by one forward solve.
  std::vector<double> jacobian(const CoefficientPair& direction);

  /// (I + S)⁻¹ of residuals (smooth_error.h), and its square root; the data's Hessian is
  /// jacobian_transpose() of weigh() of jacobian().
  void weigh(std::vector<double>& residuals) const;
  void weigh_root(std::vector<double>& white) const;

  /// r M of the last value(), [M][v][u].
  std::vector<double> prediction() const;
  /// χ² per value used of the last value() (data_term.h).
  double chi2_per_value() const { return data_term_.chi2_per_value; }
  /// Root of the weight of each datum at the last value(), under a robust loss too.
  const std::vector<double>& root_weight() const { return data_term_.root_weight; }

  /// Sets r from one solve on the finer grid at `fields`, every voxel split, and by photons there
  /// if asked. The number of photons follows the noise of the data, or their misfit if that is
  /// larger. Returns value() with the new r; gradient() is ready. With PhotonSlope::renewed four
  /// walks in place of one also give the slope of r; otherwise r keeps its slope, if any.
  enum class PhotonSlope { kept, renewed };
  double refresh_correction(const Refinement& refinement, const CoefficientPair& fields,
                            PhotonSlope photon_slope = PhotonSlope::kept);
  const Correction& correction() const { return correction_; }
  void set_correction(Correction correction);
  /// From a checkpoint.
  void restore(Correction correction, const SolveCount& solves);
  /// Counts all that deviations are stated from: all of r's noise, as smooth changes of the medium
  /// meet it, and the error of the mean, held no more.
  void count_all_errors();

 private:
  CoefficientPair adjoint(const std::vector<double>& by_exitance);
  using LoadBatch = std::function<void(std::size_t batch, forward::BatchField& b)>;
  using UseBatch = std::function<void(std::size_t batch, const forward::BatchField& solved)>;
  void solve_adjoint(const LoadBatch& load, const UseBatch& add);
  std::array<double, 2> even_gradient(const std::vector<double>& by_exitance) const;
  bool solve_forward(const CoefficientPair& fields);
  bool solve_lights(const LoadBatch& load, const UseBatch& leave);
  void see();
  void see_device();
  std::vector<double> by_exitance() const;
  double misfit();
  bool misfit_on_device() const;
  bool solve_on_device(const device::Buffer& logs);
  void adjoint_on_device(const device::Buffer& by_logs);
  DeviceData& device_data();
  void add_to_variance(const std::vector<double>& more);
  void correct();
  static std::array<double, 2> means(const CoefficientPair& fields);
  template <class Values>
  auto of_batch(Values& values, std::size_t part, std::size_t size) const;
  forward::SolvedBatch batch(std::size_t part) const;

  Problem problem_;
  Views views_;
  std::vector<double> light_;  ///< irradiance [light][v][u]
  std::optional<LitFace> lit_;
  Backend backend_;
  forward::SolveOptions derivative_solve_;  ///< of adjoint and tangent solves
  DataTermOptions data_options_;
  std::unique_ptr<forward::DiffusionOperator> operator_;
  std::string warning_;
  SolveCount solves_;
  std::vector<double> stated_weight_;  ///< of the data alone
  Correction correction_;
  std::vector<double> ratio_;                          ///< r at fields_
  CoefficientPair fields_;                             ///< of the last value(); empty: a device's
  std::optional<std::array<double, 2>> device_means_;  ///< of log κ and log μ, where they are
  std::vector<double> leaving_;   ///< exitance of the last value() [light][face][v][u]
  std::vector<double> exitance_;  ///< M of the last value(), its pictures
  DataTerm data_term_;            ///< there
  bool seen_here_ = true;         ///< these are the last value()'s; else a device has them
  bool all_on_device_ = false;    ///< medium, solves and gradients of host vectors too
  std::unique_ptr<DeviceData> device_data_;  ///< null: no value() there yet
  bool data_on_device_ = false;              ///< device_data_ has r and the weights that are here
  std::size_t used_ = 0;                     ///< of those data
  std::vector<std::unique_ptr<forward::BatchField>> fluence_;  ///< φ of the last value(), by batch
};

}  // namespace kappamu::inverse
