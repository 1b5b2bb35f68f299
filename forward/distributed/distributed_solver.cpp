#include "forward/distributed/distributed_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/distributed/piece_matrix.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/solve_verdict.h"

namespace kappamu::forward::distributed {

namespace {

struct PieceField final : BatchField {
  PieceField(const BlockPieces& pieces, int count) {
    for (int m = 0; m < count; ++m) pattern.push_back(pieces.make_vector());
  }
  int patterns() const override { return static_cast<int>(pattern.size()); }
  std::vector<Vector> pattern;
};

const PieceField& cast(const BatchField& field) {
  const auto* own = dynamic_cast<const PieceField*>(&field);
  check(own != nullptr, "a field of another backend was given to the distributed solver");
  return *own;
}
PieceField& cast(BatchField& field) {
  return const_cast<PieceField&>(cast(std::as_const(field)));
}

/// Unless PETSC_OPTIONS says otherwise. hypre's BoomerAMG with the parallel coarsening and the
/// short interpolation that need least memory (docs/distributed.md, "Solver").
void set_usual_options() {
  const auto usual = [](const char* name, const char* value) {
    PetscBool given = PETSC_FALSE;
    petsc(PetscOptionsHasName(nullptr, nullptr, name, &given));
    if (given == PETSC_FALSE) petsc(PetscOptionsSetValue(nullptr, name, value));
  };
#ifdef PETSC_HAVE_HYPRE
  usual("-kappamu_pc_type", "hypre");
  usual("-kappamu_pc_hypre_type", "boomeramg");
  usual("-kappamu_pc_hypre_boomeramg_strong_threshold", "0.5");
  usual("-kappamu_pc_hypre_boomeramg_coarsen_type", "HMIS");
  usual("-kappamu_pc_hypre_boomeramg_interp_type", "ext+i");
  usual("-kappamu_pc_hypre_boomeramg_P_max", "4");
  usual("-kappamu_pc_hypre_boomeramg_agg_nl", "1");
#else
  usual("-kappamu_pc_type", "gamg");
  usual("-kappamu_pc_gamg_threshold", "0.01");
#endif
}

class DistributedSolver final : public GridSolver {
 public:
  explicit DistributedSolver(std::shared_ptr<const BlockPieces> pieces)
      : pieces_(std::move(pieces)) {
    validate(pieces_->whole());
    constants_ = constants_of(pieces_->whole());
    matrix_ = make_matrix(*pieces_);
    make_krylov();
  }

  const GridSetup& setup() const override { return pieces_->piece(); }
  const BoundaryConstants& constants() const override { return constants_; }
  std::string backend() const override {
    return "PETSc, double, " + std::to_string(pieces_->ranks()) + " ranks";
  }

  void set_medium(std::span<const double> kappa, std::span<const double> mu) override;
  std::unique_ptr<BatchField> make_field(int patterns) const override {
    check(patterns >= 1, "a field needs at least one pattern");
    return std::make_unique<PieceField>(*pieces_, patterns);
  }
  void fill(BatchField& field, std::span<const double> values) const override;
  void read(const BatchField& field, std::span<double> values) const override;
  void light_source(std::span<const double> irradiance, BatchField& b) const override;
  void exitance_adjoint(Face face, std::span<const double> weights, BatchField& b) const override;
  void apply(const BatchField& phi, BatchField& y) const override;
  SolveReport solve(const BatchField& b, BatchField& phi,
                    const SolveOptions& options) const override;
  void exitance(const BatchField& phi, Face face, std::span<const double> irradiance,
                std::span<double> out) const override;
  PairProducts pair_products(const BatchField& lambda, const BatchField& phi) const override;
  std::vector<double> column_products(const BatchField& lambda,
                                      std::span<const double> irradiance) const override;
  std::vector<double> weighted_sums(const BatchField& phi,
                                    std::span<const double> weight) const override;
  void change_source(const EquationsChange& change, const BatchField& phi,
                     std::span<const double> irradiance, BatchField& b) const override;

 private:
  void make_krylov();
  double area() const { return setup().shape.voxel_mm * setup().shape.voxel_mm; }
  std::size_t cells() const { return setup().shape.cells(); }
  std::size_t pixels(Face face) const { return face_shape(setup().shape, face).cells(); }
  /// G_b of a face's voxel [mm²].
  double conductance(Face face, std::size_t cell) const {
    const double voxel = setup().shape.voxel_mm;
    return is_open(setup(), face) ? robin_conductance(kappa_[cell], voxel, constants_.A) : 0.0;
  }
  /// f(pixel [v][u], cell of the piece below it), of the rank's own pixels of a face.
  template <class F>
  void for_pixels(Face face, F f) const {
    const FaceShape s = face_shape(setup().shape, face);
    for (int v = 0; v < s.nv; ++v) {
      for (int u = 0; u < s.nu; ++u) {
        if (!pieces_->owns_pixel(face, u, v)) continue;
        f(static_cast<std::size_t>(v) * s.nu + u, face_cell(setup().shape, face, u, v));
      }
    }
  }
  /// By cell of the piece: its pixel of the lit face.
  std::size_t column_of(std::size_t cell) const;

  std::shared_ptr<const BlockPieces> pieces_;
  BoundaryConstants constants_;
  Matrix matrix_;
  Solver krylov_;
  std::vector<double> kappa_;      ///< of the piece
  std::vector<double> deposited_;  ///< b per irradiance on the column, of the piece [mm²]
};

void DistributedSolver::make_krylov() {
  set_usual_options();
  petsc(KSPCreate(pieces_->comm(), krylov_.receive()));
  KSP krylov = krylov_.get();
  petsc(KSPSetOptionsPrefix(krylov, "kappamu_"));
  petsc(KSPSetType(krylov, KSPCG));
  petsc(KSPSetNormType(krylov, KSP_NORM_UNPRECONDITIONED));
  petsc(KSPSetInitialGuessNonzero(krylov, PETSC_TRUE));
  petsc(KSPSetDM(krylov, pieces_->grid()));
  petsc(KSPSetDMActive(krylov, PETSC_FALSE));
  petsc(KSPSetOperators(krylov, matrix_.get(), matrix_.get()));
  petsc(KSPSetFromOptions(krylov));
}

std::size_t DistributedSolver::column_of(std::size_t cell) const {
  const auto nx = static_cast<std::size_t>(setup().shape.nx);
  const auto ny = static_cast<std::size_t>(setup().shape.ny);
  const std::array<std::size_t, 3> at{cell % nx, cell / nx % ny, cell / nx / ny};
  const auto [u, v] = face_axes(setup().lit_face);
  return at[v] * static_cast<std::size_t>(face_shape(setup().shape, setup().lit_face).nu) + at[u];
}

void DistributedSolver::set_medium(std::span<const double> kappa, std::span<const double> mu) {
  validate_medium(setup().shape, kappa, mu);
  kappa_.assign(kappa.begin(), kappa.end());
  assemble(*pieces_, constants_.A, kappa, mu, matrix_.get());
  petsc(KSPSetOperators(krylov_.get(), matrix_.get(), matrix_.get()));
  petsc(KSPSetUp(krylov_.get()));
  if (setup().source == SourceModel::first_collision) {
    deposited_ = beam_fate(setup(), kappa, mu).scattered;
    for (double& share : deposited_) share *= constants_.normal_transmittance * area();
    return;
  }
  deposited_.assign(cells(), 0.0);
  const double q = boundary_q_per_irradiance(setup(), constants_);
  for_pixels(setup().lit_face, [&](std::size_t, std::size_t i) {
    deposited_[i] = q * conductance(setup().lit_face, i);
  });
}

void DistributedSolver::fill(BatchField& field, std::span<const double> values) const {
  PieceField& own = cast(field);
  check(values.size() == cells() * own.pattern.size(), "fill: wrong number of values");
  for (std::size_t m = 0; m < own.pattern.size(); ++m) {
    pieces_->fill(own.pattern[m].get(), values.subspan(m * cells(), cells()));
  }
}

void DistributedSolver::read(const BatchField& field, std::span<double> values) const {
  const PieceField& own = cast(field);
  check(values.size() == cells() * own.pattern.size(), "read: wrong number of values");
  for (std::size_t m = 0; m < own.pattern.size(); ++m) {
    pieces_->read(own.pattern[m].get(), values.subspan(m * cells(), cells()));
  }
}

void DistributedSolver::light_source(std::span<const double> irradiance, BatchField& b) const {
  PieceField& own = cast(b);
  const std::size_t lit = pixels(setup().lit_face);
  check(irradiance.size() == lit * own.pattern.size(), "light_source: wrong number of irradiances");
  for (std::size_t m = 0; m < own.pattern.size(); ++m) {
    const Values rhs(own.pattern[m].get());
    pieces_->for_own([&](std::size_t i, std::size_t k) {
      rhs[k] = deposited_[i] == 0.0 ? 0.0 : deposited_[i] * irradiance[m * lit + column_of(i)];
    });
  }
}

void DistributedSolver::exitance_adjoint(Face face, std::span<const double> weights,
                                         BatchField& b) const {
  PieceField& own = cast(b);
  const std::size_t count = pixels(face);
  check(weights.size() == count * own.pattern.size(), "exitance_adjoint: wrong number of weights");
  const double scale = exitance_per_flux(setup()) / area();
  std::vector<double> rhs(cells());
  for (std::size_t m = 0; m < own.pattern.size(); ++m) {
    std::fill(rhs.begin(), rhs.end(), 0.0);
    for_pixels(face, [&](std::size_t k, std::size_t i) {
      rhs[i] = scale * weights[m * count + k] * conductance(face, i);
    });
    pieces_->fill(own.pattern[m].get(), rhs);
  }
}

void DistributedSolver::apply(const BatchField& phi, BatchField& y) const {
  const PieceField& in = cast(phi);
  PieceField& out = cast(y);
  check(in.pattern.size() == out.pattern.size(), "apply: fields of different batches");
  for (std::size_t m = 0; m < in.pattern.size(); ++m) {
    petsc(MatMult(matrix_.get(), in.pattern[m].get(), out.pattern[m].get()));
  }
}

SolveReport DistributedSolver::solve(const BatchField& b, BatchField& phi,
                                     const SolveOptions& options) const {
  const Stopwatch watch;
  const PieceField& rhs = cast(b);
  PieceField& x = cast(phi);
  check(rhs.pattern.size() == x.pattern.size(), "solve: fields of different batches");
  check(!kappa_.empty(), "set_medium must come before the first use of the solver");
  KSP krylov = krylov_.get();
  petsc(KSPSetTolerances(krylov, options.tolerance, 1e-300, PETSC_DEFAULT, options.max_iterations));
  SolveReport report;
  for (std::size_t m = 0; m < rhs.pattern.size(); ++m) {
    double norm = 0.0, residual = 0.0;
    PetscInt iterations = 0;
    petsc(VecNorm(rhs.pattern[m].get(), NORM_2, &norm));
    if (norm == 0.0) {
      petsc(VecSet(x.pattern[m].get(), 0.0));
      report.residual.push_back(0.0);
      continue;
    }
    petsc(KSPSolve(krylov, rhs.pattern[m].get(), x.pattern[m].get()));
    petsc(KSPGetResidualNorm(krylov, &residual));
    petsc(KSPGetIterationNumber(krylov, &iterations));
    report.iterations = std::max(report.iterations, static_cast<int>(iterations));
    report.residual.push_back(residual / norm);
    if (!std::isfinite(residual / norm)) break;
  }
  conclude(report, options.tolerance, report.iterations < options.max_iterations,
           Precision::double_precision);
  report.seconds = watch.seconds();
  return report;
}

void DistributedSolver::exitance(const BatchField& phi, Face face,
                                 std::span<const double> irradiance, std::span<double> out) const {
  const PieceField& own = cast(phi);
  const std::size_t count = pixels(face);
  check(out.size() == count * own.pattern.size(), "exitance: wrong number of outputs");
  const bool entering = face == setup().lit_face && setup().source == SourceModel::boundary;
  check(!entering || irradiance.size() == out.size(), "exitance: the lit face needs irradiance");
  const double q = boundary_q_per_irradiance(setup(), constants_);
  const double apart = exitance_per_irradiance(setup(), constants_);
  const double scale = exitance_per_flux(setup()) / area();
  std::fill(out.begin(), out.end(), 0.0);
  std::vector<double> values(cells());
  for (std::size_t m = 0; m < own.pattern.size(); ++m) {
    pieces_->read(own.pattern[m].get(), values);
    for_pixels(face, [&](std::size_t k, std::size_t i) {
      const double e = entering ? irradiance[m * count + k] : 0.0;
      out[m * count + k] = scale * conductance(face, i) * (values[i] - q * e) + apart * e;
    });
  }
}

PairProducts DistributedSolver::pair_products(const BatchField& lambda,
                                              const BatchField& phi) const {
  const PieceField& l = cast(lambda);
  const PieceField& p = cast(phi);
  check(l.pattern.size() == p.pattern.size(), "pair_products: fields of different batches");
  const GridShape& s = setup().shape;
  PairProducts sums;
  for (auto* v : {&sums.cell, &sums.face_x, &sums.face_y, &sums.face_z}) v->assign(s.cells(), 0.0);
  std::vector<double> a(s.cells(), 0.0), c(s.cells(), 0.0);
  for (std::size_t m = 0; m < l.pattern.size(); ++m) {
    pieces_->read(l.pattern[m].get(), a);
    pieces_->read(p.pattern[m].get(), c);
    const auto across = [&](std::size_t i, std::size_t j) { return (a[i] - a[j]) * (c[i] - c[j]); };
    pieces_->for_own([&](std::size_t i, std::size_t) { sums.cell[i] += a[i] * c[i]; });
    for (std::size_t i = 0, z = 0; z < static_cast<std::size_t>(s.nz); ++z) {
      for (int y = 0; y < s.ny; ++y) {
        for (int x = 0; x < s.nx; ++x, ++i) {
          if (x + 1 < s.nx) sums.face_x[i] += across(i, i + 1);
          if (y + 1 < s.ny) sums.face_y[i] += across(i, i + s.nx);
          if (z + 1 < static_cast<std::size_t>(s.nz)) {
            sums.face_z[i] += across(i, i + static_cast<std::size_t>(s.nx) * s.ny);
          }
        }
      }
    }
  }
  return sums;
}

std::vector<double> DistributedSolver::column_products(const BatchField& lambda,
                                                       std::span<const double> irradiance) const {
  const PieceField& own = cast(lambda);
  const std::size_t lit = pixels(setup().lit_face);
  check(irradiance.size() == lit * own.pattern.size(),
        "column_products: wrong number of irradiances");
  std::vector<double> sums(cells(), 0.0);
  for (std::size_t m = 0; m < own.pattern.size(); ++m) {
    const ConstValues values(own.pattern[m].get());
    pieces_->for_own([&](std::size_t i, std::size_t k) {
      sums[i] += values[k] * irradiance[m * lit + column_of(i)];
    });
  }
  return sums;
}

std::vector<double> DistributedSolver::weighted_sums(const BatchField& phi,
                                                     std::span<const double> weight) const {
  check(weight.size() == cells(), "weighted_sums: the weight does not fit the grid");
  std::vector<double> sums;
  for (const Vector& vector : cast(phi).pattern) {
    const ConstValues values(vector.get());
    double sum = 0.0;
    pieces_->for_own([&](std::size_t i, std::size_t k) { sum += weight[i] * values[k]; });
    sums.push_back(sum);
  }
  return sums;
}

void DistributedSolver::change_source(const EquationsChange& change, const BatchField& phi,
                                      std::span<const double> irradiance, BatchField& b) const {
  const PieceField& in = cast(phi);
  PieceField& out = cast(b);
  const GridShape& s = setup().shape;
  const std::size_t lit = pixels(setup().lit_face);
  check(in.pattern.size() == out.pattern.size() && irradiance.size() == lit * in.pattern.size(),
        "change_source: fields or light do not fit each other");
  const std::array<std::size_t, 3> step{1, static_cast<std::size_t>(s.nx),
                                        static_cast<std::size_t>(s.nx) * s.ny};
  const std::array<const std::vector<double>*, 3> faces{&change.face_x, &change.face_y,
                                                        &change.face_z};
  std::vector<double> x(s.cells(), 0.0);
  for (std::size_t m = 0; m < in.pattern.size(); ++m) {
    pieces_->read(in.pattern[m].get(), x);
    const Values rhs(out.pattern[m].get());
    pieces_->for_own([&](std::size_t i, std::size_t k) {
      const double e = irradiance[m * lit + column_of(i)];
      double sum = change.source[i] * e - change.diagonal[i] * x[i];
      const std::array<std::size_t, 3> at{i % step[1], i / step[1] % s.ny, i / step[2]};
      for (int axis = 0; axis < 3; ++axis) {
        const std::vector<double>& face = *faces[axis];
        const std::size_t d = step[axis];
        if (at[axis] > 0) sum -= face[i - d] * (x[i] - x[i - d]);
        if (at[axis] + 1 < static_cast<std::size_t>(s.extent(axis))) {
          sum -= face[i] * (x[i] - x[i + d]);
        }
      }
      rhs[k] = sum;
    });
  }
}

class DistributedOperators final : public OperatorFactory {
 public:
  explicit DistributedOperators(std::vector<std::shared_ptr<const BlockPieces>> pieces)
      : pieces_(std::move(pieces)) {}
  MadeOperator make(const GridSetup& setup, const SeenFaces& seen, const std::string& /*device*/,
                    Precision /*precision*/) const override {
    const auto found = std::find_if(pieces_.begin(), pieces_.end(), [&](const auto& pieces) {
      return pieces->piece().shape == setup.shape;
    });
    check(found != pieces_.end(), "a grid that was not cut to pieces");
    return {make_grid_operator(make_distributed_solver(*found), seen), ""};
  }
  /// A row of the matrix and of its hierarchy, whose grids add about as much again; work vectors.
  std::size_t memory(const GridSetup& setup, int patterns, int fields, int at_once,
                     Precision /*precision*/) const override {
    constexpr std::size_t matrix = 2 * 7 * (sizeof(double) + sizeof(PetscInt));
    constexpr std::size_t work = 12 * sizeof(double);
    const auto kept = static_cast<std::size_t>(patterns) * static_cast<std::size_t>(fields) +
                      2 * static_cast<std::size_t>(at_once);
    return setup.shape.cells() * (matrix + work + kept * sizeof(double));
  }

 private:
  std::vector<std::shared_ptr<const BlockPieces>> pieces_;
};

}  // namespace

std::unique_ptr<GridSolver> make_distributed_solver(std::shared_ptr<const BlockPieces> pieces) {
  return std::make_unique<DistributedSolver>(std::move(pieces));
}

std::shared_ptr<const OperatorFactory> distributed_operators(
    std::vector<std::shared_ptr<const BlockPieces>> pieces) {
  return std::make_shared<DistributedOperators>(std::move(pieces));
}

}  // namespace kappamu::forward::distributed
