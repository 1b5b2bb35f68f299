// A block's grid as a DiffusionOperator: light on one face, exitance of one face or of several.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/numbers/elementary.h"
#include "core/parallel.h"
#include "forward/device_medium.h"
#include "forward/grid/derivatives.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/solver_memory.h"

namespace kappamu::forward {

namespace {

/// Pixels of the seen face that a thread sums over the patterns at once.
constexpr std::size_t seen_at_once = 4096;

class GridOperator final : public DiffusionOperator, DeviceMedium {
 public:
  GridOperator(std::unique_ptr<GridSolver> solver, const SeenFaces& seen)
      : solver_(std::move(solver)),
        seen_(seen.list),
        space_(block_space(setup().shape, setup().lit_face)),
        pixels_(face_shape(setup().shape, seen_.front()).cells()) {
    for (const Face face : seen_) {
      check(face_shape(setup().shape, face).cells() == pixels_, "faces of one shape are seen");
      apart_.push_back(is_lit(face) ? exitance_per_irradiance(setup(), solver_->constants()) : 0.0);
    }
  }

  const MediumSpace& space() const override { return space_; }
  std::size_t light_size() const override {
    return face_shape(space_.shape, setup().lit_face).cells();
  }
  std::size_t exitance_size() const override { return seen_.size() * pixels_; }
  std::string backend() const override { return solver_->backend(); }

  void set_medium(std::vector<double> kappa, std::vector<double> mu) override {
    solver_->set_medium(kappa, mu);
    host_medium_ = {std::move(kappa), std::move(mu)};
  }
  std::unique_ptr<BatchField> make_field(int patterns) const override {
    return solver_->make_field(patterns);
  }
  void load(std::span<const double> light, BatchField& b) const override {
    solver_->light_source(light, b);
  }
  void load_transpose(const BatchField& lambda, std::span<double> light) const override;
  void interpolate(const BatchField& coarse, const GridShape& shape, int first,
                   BatchField& phi) const override {
    solver_->interpolate(coarse, shape, first, phi);
  }
  SolveReport solve(const BatchField& b, BatchField& phi,
                    const SolveOptions& options) const override {
    return solver_->solve(b, phi, options);
  }
  void exitance(const BatchField& phi, std::span<const double> light,
                std::span<double> out) const override;
  void exitance_transpose(std::span<const double> weights, BatchField& b) const override;
  void add_gradient(const SolvedBatch& at, const BatchField& lambda,
                    std::span<const double> weights, CoefficientPair& gradient) const override;
  void linearise(const SolvedBatch& at, const CoefficientPair& direction, BatchField& b,
                 std::span<double> exitance_change) const override;

  forward::DeviceMedium* on_device() override { return solver_->on_device() ? this : nullptr; }
  device::Context& context() const override { return solver_->on_device()->context(); }
  void set(const device::Buffer& logs) override {
    solver_->on_device()->set_medium(logs);
    host_medium_.reset();
  }
  void load(const device::Buffer& light, BatchField& b) const override {
    solver_->on_device()->light_source(light, b);
  }
  void exitance(const BatchField& phi, const device::Buffer& light,
                const device::Buffer& out) const override {
    solver_->on_device()->exitance(phi, seen_, light, out);
  }
  void exitance_transpose(const device::Buffer& weights, BatchField& b) const override {
    solver_->on_device()->exitance_adjoint(seen_, weights, b);
  }
  void add_gradient(const DeviceBatch& at, const BatchField& lambda, const device::Buffer& weights,
                    const device::Buffer& gradient) const override {
    solver_->on_device()->add_gradient(lambda, at, seen_, weights, gradient);
  }

 private:
  /// κ [mm] and μ [1/mm] on the host.
  struct HostMedium {
    std::vector<double> kappa, mu;
  };
  const HostMedium& medium() const {
    if (!host_medium_) {
      CoefficientPair logs = solver_->on_device()->medium();
      for (std::vector<double>* values : {&logs.log_kappa, &logs.log_mu}) {
        for_ranges(values->size(), [&](std::size_t begin, std::size_t end) {
          exponentiate({values->data() + begin, end - begin});
        });
      }
      host_medium_ = {std::move(logs.log_kappa), std::move(logs.log_mu)};
    }
    return *host_medium_;
  }
  std::vector<double> observed(const SolvedBatch& at, std::span<const double> weights) const;
  const GridSetup& setup() const { return solver_->setup(); }
  bool is_lit(Face face) const { return face == setup().lit_face; }
  /// The part of the exitance of datum `i` that a conductance multiplies.
  double conducted(const SolvedBatch& at, std::size_t i) const {
    const double apart = apart_[i / pixels_ % seen_.size()];
    if (apart == 0.0) return at.exitance[i];
    return at.exitance[i] - apart * at.light[i / exitance_size() * pixels_ + i % pixels_];
  }

  std::unique_ptr<GridSolver> solver_;
  std::vector<Face> seen_;
  MediumSpace space_;
  std::size_t pixels_;  ///< of one of them
  std::vector<double>
      apart_;  ///< of their exitance, per irradiance: what no conductance multiplies
  mutable std::optional<HostMedium> host_medium_ = HostMedium{};  ///< none: the device's, not read
};

void GridOperator::exitance(const BatchField& phi, std::span<const double> light,
                            std::span<double> out) const {
  std::vector<double> of_face(static_cast<std::size_t>(phi.patterns()) * pixels_);
  for (std::size_t f = 0; f < seen_.size(); ++f) {
    const std::span<double> result = seen_.size() == 1 ? out : std::span<double>(of_face);
    solver_->exitance(phi, seen_[f], is_lit(seen_[f]) ? light : std::span<const double>(), result);
    if (seen_.size() == 1) return;
    for (std::size_t i = 0; i < of_face.size(); ++i) {
      out[(i / pixels_ * seen_.size() + f) * pixels_ + i % pixels_] = of_face[i];
    }
  }
}

void GridOperator::exitance_transpose(std::span<const double> weights, BatchField& b) const {
  if (seen_.size() == 1) {
    solver_->exitance_adjoint(seen_.front(), weights, b);
    return;
  }
  const auto patterns = static_cast<std::size_t>(b.patterns());
  std::vector<double> of_face(patterns * pixels_);
  std::vector<double> sum(patterns * space_.cells(), 0.0), one(sum.size());
  for (std::size_t f = 0; f < seen_.size(); ++f) {
    for (std::size_t i = 0; i < of_face.size(); ++i) {
      of_face[i] = weights[(i / pixels_ * seen_.size() + f) * pixels_ + i % pixels_];
    }
    solver_->exitance_adjoint(seen_[f], of_face, b);
    solver_->read(b, one);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += one[i];
  }
  solver_->fill(b, sum);
}

void GridOperator::load_transpose(const BatchField& lambda, std::span<double> light) const {
  const GridShape& shape = space_.shape;
  const FaceShape face = face_shape(shape, setup().lit_face);
  const double area = shape.voxel_mm * shape.voxel_mm;
  std::vector<double> fields(shape.cells() * static_cast<std::size_t>(lambda.patterns()));
  solver_->read(lambda, fields);
  const bool beam = setup().source == SourceModel::first_collision;
  const std::vector<double> scattered =
      beam ? beam_fate(setup(), medium().kappa, medium().mu).scattered : std::vector<double>();
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
          sum = robin.conductance(medium().kappa[i]) * q * of_pattern[i];
        }
        light[m * face.cells() + static_cast<std::size_t>(v) * face.nu + u] = sum;
      }
    }
  }
}

/// AdjointSums::observed.
std::vector<double> GridOperator::observed(const SolvedBatch& at,
                                           std::span<const double> weights) const {
  const std::size_t seen = exitance_size();
  std::vector<double> sums(seen, 0.0);
  for_pieces(seen, seen_at_once, [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t pattern = 0; pattern < weights.size(); pattern += seen) {
      for (std::size_t s = first; s < last; ++s) {
        sums[s] += weights[pattern + s] * conducted(at, pattern + s);
      }
    }
  });
  return sums;
}

void GridOperator::add_gradient(const SolvedBatch& at, const BatchField& lambda,
                                std::span<const double> weights, CoefficientPair& gradient) const {
  const AdjointSums sums{solver_->pair_products(lambda, at.phi),
                         solver_->column_products(lambda, at.light), observed(at, weights)};
  forward::add_gradient(setup(), solver_->constants(), seen_, medium().kappa, medium().mu, sums,
                        gradient);
}

void GridOperator::linearise(const SolvedBatch& at, const CoefficientPair& direction, BatchField& b,
                             std::span<double> exitance_change) const {
  const Tangent tangent = forward::linearise(setup(), solver_->constants(), seen_, medium().kappa,
                                             medium().mu, direction);
  solver_->change_source(tangent.equations, at.phi, at.light, b);
  const std::size_t seen = exitance_size();
  for (std::size_t i = 0; i < exitance_change.size(); ++i) {
    exitance_change[i] = tangent.observed[i % seen] * conducted(at, i);
  }
}

class BlockOperators final : public OperatorFactory {
 public:
  MadeOperator make(const GridSetup& setup, const SeenFaces& seen, const std::string& device,
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
                                                      const SeenFaces& seen) {
  return std::make_unique<GridOperator>(std::move(solver), seen);
}

std::shared_ptr<const OperatorFactory> block_operators() {
  static const std::shared_ptr<const OperatorFactory> made = std::make_shared<BlockOperators>();
  return made;
}

}  // namespace kappamu::forward
