// The serial double reference: the equations of grid_solver.h written out cell by cell, solved one
// pattern at a time by conjugate gradients with a modified incomplete Cholesky preconditioner. It
// shares no discretisation code with the OpenCL backend, so that each can convict the other.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/grid/grid_physics.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/reference/reference_matrix.h"
#include "forward/grid/solve_verdict.h"

namespace kappamu::forward {

namespace {

using reference::CgResult;
using reference::Matrix;
using reference::Vector;

struct ReferenceField final : BatchField {
  explicit ReferenceField(int count, std::size_t cells)
      : pattern(static_cast<std::size_t>(count), Vector(cells, 0.0)) {}
  int patterns() const override { return static_cast<int>(pattern.size()); }
  std::vector<Vector> pattern;  ///< [pattern][z][y][x]
};

ReferenceField& cast(BatchField& field) {
  auto* own = dynamic_cast<ReferenceField*>(&field);
  check(own != nullptr, "a field of another backend was given to the reference solver");
  return *own;
}
const ReferenceField& cast(const BatchField& field) {
  const auto* own = dynamic_cast<const ReferenceField*>(&field);
  check(own != nullptr, "a field of another backend was given to the reference solver");
  return *own;
}

class ReferenceSolver final : public GridSolver {
 public:
  explicit ReferenceSolver(const GridSetup& setup) : setup_(setup) {
    validate(setup_);
    constants_ = constants_of(setup_);
  }

  const GridSetup& setup() const override { return setup_; }
  const BoundaryConstants& constants() const override { return constants_; }
  std::string backend() const override { return "reference"; }

  void set_medium(std::span<const double> kappa, std::span<const double> mu) override {
    validate_medium(setup_.shape, kappa, mu);
    kappa_.assign(kappa.begin(), kappa.end());
    mu_.assign(mu.begin(), mu.end());
    matrix_.emplace(setup_, constants_.A, kappa, mu);
  }

  std::unique_ptr<BatchField> make_field(int patterns) const override {
    check(patterns >= 1, "a field needs at least one pattern");
    return std::make_unique<ReferenceField>(patterns, setup_.shape.cells());
  }

  void fill(BatchField& field, std::span<const double> values) const override {
    ReferenceField& own = cast(field);
    const std::size_t n = setup_.shape.cells();
    check(values.size() == n * own.pattern.size(), "fill: wrong number of values");
    for (std::size_t m = 0; m < own.pattern.size(); ++m) {
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(m * n), n, own.pattern[m].begin());
    }
  }

  void read(const BatchField& field, std::span<double> values) const override {
    const ReferenceField& own = cast(field);
    const std::size_t n = setup_.shape.cells();
    check(values.size() == n * own.pattern.size(), "read: wrong number of values");
    for (std::size_t m = 0; m < own.pattern.size(); ++m) {
      std::copy_n(own.pattern[m].begin(), n, values.begin() + static_cast<std::ptrdiff_t>(m * n));
    }
  }

  void light_source(std::span<const double> irradiance, BatchField& b) const override {
    ReferenceField& own = cast(b);
    const Face lit = setup_.lit_face;
    check(irradiance.size() == face_shape(setup_.shape, lit).cells() * own.pattern.size(),
          "light_source: wrong number of irradiances");
    for (Vector& values : own.pattern) std::fill(values.begin(), values.end(), 0.0);
    const double h = setup_.shape.voxel_mm;
    const double q = boundary_q_per_irradiance(setup_, constants_);
    for_each_sample(lit, own, [&](std::size_t sample, std::size_t k, Vector& rhs, int u, int v) {
      if (setup_.source == SourceModel::boundary) {
        rhs[face_cell(setup_.shape, lit, u, v)] = matrix().robin(lit)[k] * q * irradiance[sample];
        return;
      }
      // Power entering the column, followed to the far face, back, and so on.
      double power = constants_.normal_transmittance * irradiance[sample] * h * h;
      const double nothing = 1e-17 * std::abs(power);
      const int depth = setup_.shape.extent(axis_of(lit));
      for (bool away = true; std::abs(power) > nothing; away = !away) {
        for (int step = 0; step < depth; ++step) {
          const int w = away ? step : depth - 1 - step;
          const std::size_t i = face_cell(setup_.shape, lit, u, v, w);
          const double extinction = 1.0 / (3.0 * kappa_[i]);
          const double scattering = std::max(0.0, extinction - mu_[i]);
          rhs[i] += power * scattering / extinction * -std::expm1(-extinction * h);
          power *= std::exp(-extinction * h);
        }
        power *= fresnel_internal(setup_.eta, 1.0);
      }
    });
  }

  void exitance_adjoint(Face face, std::span<const double> weights, BatchField& b) const override {
    ReferenceField& own = cast(b);
    check(weights.size() == face_shape(setup_.shape, face).cells() * own.pattern.size(),
          "exitance_adjoint: wrong number of weights");
    for (Vector& values : own.pattern) std::fill(values.begin(), values.end(), 0.0);
    const double scale = exitance_per_flux(setup_) / voxel_area();
    for_each_sample(face, own, [&](std::size_t sample, std::size_t k, Vector& rhs, int u, int v) {
      rhs[face_cell(setup_.shape, face, u, v)] = matrix().robin(face)[k] * scale * weights[sample];
    });
  }

  void apply(const BatchField& phi, BatchField& y) const override {
    const ReferenceField& in = cast(phi);
    ReferenceField& out = cast(y);
    check(in.pattern.size() == out.pattern.size(), "apply: fields of different batches");
    for (std::size_t m = 0; m < in.pattern.size(); ++m) {
      matrix().apply(in.pattern[m], out.pattern[m]);
    }
  }

  void interpolate(const BatchField& coarse, const GridShape& shape, int first,
                   BatchField& phi) const override {
    const auto* from = dynamic_cast<const ReferenceField*>(&coarse);
    ReferenceField& fine = cast(phi);
    if (from == nullptr || first + fine.patterns() > from->patterns()) return;
    // The cell that a fine one lies in, three quarters, and the next beside it.
    const auto pair = [](int i, int count) {
      return std::array<int, 2>{i / 2,
                                std::clamp(i % 2 == 0 ? i / 2 - 1 : i / 2 + 1, 0, count - 1)};
    };
    constexpr std::array<double, 2> share{0.75, 0.25};
    for (std::size_t m = 0; m < fine.pattern.size(); ++m) {
      const Vector& values = from->pattern[static_cast<std::size_t>(first) + m];
      for_each_cell([&](std::size_t i, int x, int y, int z) {
        double sum = 0.0;
        for (std::size_t k = 0; k < 8; ++k) {
          const std::size_t a = k & 1, b = k >> 1 & 1, c = k >> 2;
          sum +=
              share[a] * share[b] * share[c] *
              values[shape.index(pair(x, shape.nx)[a], pair(y, shape.ny)[b], pair(z, shape.nz)[c])];
        }
        fine.pattern[m][i] = sum;
      });
    }
  }

  SolveReport solve(const BatchField& b, BatchField& phi,
                    const SolveOptions& options) const override {
    const Stopwatch watch;
    const ReferenceField& rhs = cast(b);
    ReferenceField& x = cast(phi);
    check(rhs.pattern.size() == x.pattern.size(), "solve: fields of different batches");
    SolveReport report;
    for (std::size_t m = 0; m < rhs.pattern.size(); ++m) {
      const CgResult one = conjugate_gradients(matrix(), rhs.pattern[m], x.pattern[m], options);
      report.iterations = std::max(report.iterations, one.iterations);
      report.residual.push_back(one.residual);
      if (!std::isfinite(one.residual)) break;
    }
    conclude(report, options.tolerance, report.iterations < options.max_iterations,
             Precision::double_precision);
    report.seconds = watch.seconds();
    return report;
  }

  void exitance(const BatchField& phi, Face face, std::span<const double> irradiance,
                std::span<double> out) const override {
    const ReferenceField& own = cast(phi);
    check(out.size() == face_shape(setup_.shape, face).cells() * own.pattern.size(),
          "exitance: wrong number of outputs");
    const bool entering = face == setup_.lit_face && setup_.source == SourceModel::boundary;
    check(!entering || irradiance.size() == out.size(), "exitance: the lit face needs irradiance");
    const double q = boundary_q_per_irradiance(setup_, constants_);
    const double apart = exitance_per_irradiance(setup_, constants_);
    const double scale = exitance_per_flux(setup_) / voxel_area();
    for_each_sample(face, own,
                    [&](std::size_t sample, std::size_t k, const Vector& x, int u, int v) {
                      const double e = entering ? irradiance[sample] : 0.0;
                      const double below = x[face_cell(setup_.shape, face, u, v)];
                      out[sample] = scale * matrix().robin(face)[k] * (below - q * e) + apart * e;
                    });
  }

  PairProducts pair_products(const BatchField& lambda, const BatchField& phi) const override {
    const ReferenceField& l = cast(lambda);
    const ReferenceField& p = cast(phi);
    check(l.pattern.size() == p.pattern.size(), "pair_products: fields of different batches");
    const GridShape& s = setup_.shape;
    PairProducts sums;
    for (Vector* v : {&sums.cell, &sums.face_x, &sums.face_y, &sums.face_z}) {
      v->assign(s.cells(), 0.0);
    }
    for (std::size_t m = 0; m < l.pattern.size(); ++m) {
      const Vector& a = l.pattern[m];
      const Vector& c = p.pattern[m];
      const auto across = [&](std::size_t i, std::size_t j) {
        return (a[i] - a[j]) * (c[i] - c[j]);
      };
      for_each_cell([&](std::size_t i, int x, int y, int z) {
        sums.cell[i] += a[i] * c[i];
        if (x + 1 < s.nx) sums.face_x[i] += across(i, s.index(x + 1, y, z));
        if (y + 1 < s.ny) sums.face_y[i] += across(i, s.index(x, y + 1, z));
        if (z + 1 < s.nz) sums.face_z[i] += across(i, s.index(x, y, z + 1));
      });
    }
    return sums;
  }

  std::vector<double> column_products(const BatchField& lambda,
                                      std::span<const double> irradiance) const override {
    const ReferenceField& own = cast(lambda);
    const Face lit = setup_.lit_face;
    check(irradiance.size() == face_shape(setup_.shape, lit).cells() * own.pattern.size(),
          "column_products: wrong number of irradiances");
    Vector sums(setup_.shape.cells(), 0.0);
    for_each_sample(lit, own, [&](std::size_t sample, std::size_t, const Vector& x, int u, int v) {
      for (int w = 0; w < setup_.shape.extent(axis_of(lit)); ++w) {
        const std::size_t i = face_cell(setup_.shape, lit, u, v, w);
        sums[i] += x[i] * irradiance[sample];
      }
    });
    return sums;
  }

  std::vector<double> weighted_sums(const BatchField& phi,
                                    std::span<const double> weight) const override {
    check(weight.size() == setup_.shape.cells(), "weighted_sums: the weight does not fit the grid");
    std::vector<double> sums;
    for (const Vector& x : cast(phi).pattern) {
      sums.push_back(std::inner_product(x.begin(), x.end(), weight.begin(), 0.0));
    }
    return sums;
  }

  void change_source(const EquationsChange& change, const BatchField& phi,
                     std::span<const double> irradiance, BatchField& b) const override {
    const ReferenceField& in = cast(phi);
    ReferenceField& out = cast(b);
    const GridShape& s = setup_.shape;
    check(in.pattern.size() == out.pattern.size() &&
              irradiance.size() == face_shape(s, setup_.lit_face).cells() * in.pattern.size(),
          "change_source: fields or light do not fit each other");
    for_each_sample(setup_.lit_face, out,
                    [&](std::size_t sample, std::size_t, Vector& rhs, int u, int v) {
                      for (int w = 0; w < s.extent(axis_of(setup_.lit_face)); ++w) {
                        const std::size_t i = face_cell(s, setup_.lit_face, u, v, w);
                        rhs[i] = change.source[i] * irradiance[sample];
                      }
                    });
    for (std::size_t m = 0; m < in.pattern.size(); ++m) {
      const Vector& x = in.pattern[m];
      Vector& rhs = out.pattern[m];
      const auto across = [&](double conductance, std::size_t i, std::size_t j) {
        const double flux = conductance * (x[i] - x[j]);
        rhs[i] -= flux;
        rhs[j] += flux;
      };
      for_each_cell([&](std::size_t i, int cx, int cy, int cz) {
        rhs[i] -= change.diagonal[i] * x[i];
        if (cx + 1 < s.nx) across(change.face_x[i], i, s.index(cx + 1, cy, cz));
        if (cy + 1 < s.ny) across(change.face_y[i], i, s.index(cx, cy + 1, cz));
        if (cz + 1 < s.nz) across(change.face_z[i], i, s.index(cx, cy, cz + 1));
      });
    }
  }

 private:
  /// f(cell, x, y, z)
  template <class F>
  void for_each_cell(F f) const {
    const GridShape& s = setup_.shape;
    for (int z = 0; z < s.nz; ++z) {
      for (int y = 0; y < s.ny; ++y) {
        for (int x = 0; x < s.nx; ++x) f(s.index(x, y, z), x, y, z);
      }
    }
  }
  /// f(sample in [pattern][v][u], sample in [v][u], the pattern's volume, u, v)
  template <class Field, class F>
  void for_each_sample(Face face, Field& field, F f) const {
    const FaceShape s = face_shape(setup_.shape, face);
    std::size_t sample = 0;
    for (auto& values : field.pattern) {
      std::size_t k = 0;
      for (int v = 0; v < s.nv; ++v) {
        for (int u = 0; u < s.nu; ++u) f(sample++, k++, values, u, v);
      }
    }
  }

  const Matrix& matrix() const {
    check(matrix_.has_value(), "set_medium must come before the first use of the solver");
    return *matrix_;
  }
  double voxel_area() const { return setup_.shape.voxel_mm * setup_.shape.voxel_mm; }

  GridSetup setup_;
  BoundaryConstants constants_;
  Vector kappa_, mu_;
  std::optional<Matrix> matrix_;
};

}  // namespace

std::unique_ptr<GridSolver> make_reference_solver(const GridSetup& setup) {
  return std::make_unique<ReferenceSolver>(setup);
}

}  // namespace kappamu::forward
