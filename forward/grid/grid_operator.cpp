// A block's grid as a DiffusionOperator: light on one face, exitance of one face.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "forward/grid/derivatives.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/solver_memory.h"

namespace kappamu::forward {

namespace {

/// Pixels of the seen face that a thread sums over the patterns at once.
constexpr std::size_t seen_at_once = 4096;

class GridOperator final : public DiffusionOperator {
 public:
  GridOperator(std::unique_ptr<GridSolver> solver, Face seen)
      : solver_(std::move(solver)),
        seen_(seen),
        space_(block_space(setup().shape, setup().lit_face)),
        apart_(seen == setup().lit_face ? exitance_per_irradiance(setup(), solver_->constants())
                                        : 0.0) {}

  const MediumSpace& space() const override { return space_; }
  std::size_t light_size() const override {
    return face_shape(space_.shape, setup().lit_face).cells();
  }
  std::size_t exitance_size() const override { return face_shape(space_.shape, seen_).cells(); }
  std::string backend() const override { return solver_->backend(); }

  void set_medium(std::vector<double> kappa, std::vector<double> mu) override {
    solver_->set_medium(kappa, mu);
    kappa_ = std::move(kappa);
    mu_ = std::move(mu);
  }
  std::unique_ptr<BatchField> make_field(int patterns) const override {
    return solver_->make_field(patterns);
  }
  void load(std::span<const double> light, BatchField& b) const override {
    solver_->light_source(light, b);
  }
  void load_transpose(const BatchField& lambda, std::span<double> light) const override;
  SolveReport solve(const BatchField& b, BatchField& phi,
                    const SolveOptions& options) const override {
    return solver_->solve(b, phi, options);
  }
  void exitance(const BatchField& phi, std::span<const double> light,
                std::span<double> out) const override {
    const bool needs_light = seen_ == setup().lit_face;
    solver_->exitance(phi, seen_, needs_light ? light : std::span<const double>(), out);
  }
  void exitance_transpose(std::span<const double> weights, BatchField& b) const override {
    solver_->exitance_adjoint(seen_, weights, b);
  }
  void add_gradient(const SolvedBatch& at, const BatchField& lambda,
                    std::span<const double> weights, CoefficientPair& gradient) const override;
  void linearise(const SolvedBatch& at, const CoefficientPair& direction, BatchField& b,
                 std::span<double> exitance_change) const override;

 private:
  const GridSetup& setup() const { return solver_->setup(); }
  /// The part of the exitance of datum `i` that a conductance multiplies.
  double conducted(const SolvedBatch& at, std::size_t i) const {
    return at.exitance[i] - (apart_ == 0.0 ? 0.0 : apart_ * at.light[i]);
  }

  std::unique_ptr<GridSolver> solver_;
  Face seen_;
  MediumSpace space_;
  double apart_;  ///< of the exitance, per irradiance: what no conductance multiplies
  std::vector<double> kappa_, mu_;
};

void GridOperator::load_transpose(const BatchField& lambda, std::span<double> light) const {
  const GridShape& shape = space_.shape;
  const FaceShape face = face_shape(shape, setup().lit_face);
  const double area = shape.voxel_mm * shape.voxel_mm;
  std::vector<double> fields(shape.cells() * static_cast<std::size_t>(lambda.patterns()));
  solver_->read(lambda, fields);
  const bool beam = setup().source == SourceModel::first_collision;
  const std::vector<double> scattered =
      beam ? beam_fate(setup(), kappa_, mu_).scattered : std::vector<double>();
  const double entered = area * solver_->constants().normal_transmittance;
  const double q = boundary_q_per_irradiance(setup(), solver_->constants());
  for (std::size_t m = 0; m < static_cast<std::size_t>(lambda.patterns()); ++m) {
    const double* const of_pattern = fields.data() + m * shape.cells();
    for (int v = 0; v < face.nv; ++v) {
      for (int u = 0; u < face.nu; ++u) {
        double sum = 0.0;
        for (int depth = 0; beam && depth < space_.depth(); ++depth) {
          const std::size_t i = face_cell(shape, setup().lit_face, u, v, depth);
          sum += entered * scattered[i] * of_pattern[i];
        }
        if (!beam) {
          const std::size_t i = face_cell(shape, setup().lit_face, u, v);
          const RobinFace robin{shape.voxel_mm, solver_->constants().A};
          sum = robin.conductance(kappa_[i]) * q * of_pattern[i];
        }
        light[m * face.cells() + static_cast<std::size_t>(v) * face.nu + u] = sum;
      }
    }
  }
}

void GridOperator::add_gradient(const SolvedBatch& at, const BatchField& lambda,
                                std::span<const double> weights, CoefficientPair& gradient) const {
  const std::size_t seen = exitance_size();
  AdjointSums sums{solver_->pair_products(lambda, at.phi),
                   solver_->column_products(lambda, at.light), std::vector<double>(seen, 0.0)};
  for_pieces(seen, seen_at_once, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t pattern = 0; pattern < weights.size(); pattern += seen) {
      for (std::size_t s = first; s < last; ++s) {
        sums.observed[s] += weights[pattern + s] * conducted(at, pattern + s);
      }
    }
  });
  forward::add_gradient(setup(), solver_->constants(), seen_, kappa_, mu_, sums, gradient);
}

void GridOperator::linearise(const SolvedBatch& at, const CoefficientPair& direction, BatchField& b,
                             std::span<double> exitance_change) const {
  const Tangent tangent =
      forward::linearise(setup(), solver_->constants(), seen_, kappa_, mu_, direction);
  solver_->change_source(tangent.equations, at.phi, at.light, b);
  const std::size_t seen = exitance_size();
  for (std::size_t i = 0; i < exitance_change.size(); ++i) {
    exitance_change[i] = tangent.observed[i % seen] * conducted(at, i);
  }
}

class BlockOperators final : public OperatorFactory {
 public:
  MadeOperator make(const GridSetup& setup, Face seen, const std::string& device,
                    Precision precision) const override {
    SolverChoice choice = make_grid_solver(setup, device, precision);
    return {make_grid_operator(std::move(choice.solver), seen), std::move(choice.warning)};
  }
  std::size_t memory(const GridSetup& setup, int patterns, int fields, int at_once,
                     Precision precision) const override {
    return solver_memory(setup, patterns, fields, at_once, precision);
  }
};

}  // namespace

std::unique_ptr<DiffusionOperator> make_grid_operator(std::unique_ptr<GridSolver> solver,
                                                      Face seen) {
  return std::make_unique<GridOperator>(std::move(solver), seen);
}

std::shared_ptr<const OperatorFactory> block_operators() {
  static const std::shared_ptr<const OperatorFactory> made = std::make_shared<BlockOperators>();
  return made;
}

}  // namespace kappamu::forward
