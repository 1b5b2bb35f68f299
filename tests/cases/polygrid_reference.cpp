#include "tests/cases/polygrid_reference.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/dot.h"

namespace kappamu::forward::polygrid {

namespace {

using Vector = std::vector<double>;

class ReferenceSolver final : public LinearSolver {
 public:
  explicit ReferenceSolver(const Pattern& pattern) : pattern_(pattern) {}

  CgReport solve(const std::vector<Load>& loads, std::vector<Vector>& x, double tolerance,
                 int most_iterations) override {
    CgReport report;
    x.resize(loads.size());
    for (std::size_t l = 0; l < loads.size(); ++l) {
      x[l].resize(pattern_.rows(), 0.0);
      solve_one(media()[loads[l].channel].value, loads[l].power, x[l], tolerance, most_iterations,
                report);
    }
    return report;
  }

 private:
  void media_changed(std::span<const int>) override {}

  Vector product(const Vector& value, const Vector& x) const {
    Vector y(x.size(), 0.0);
    for (std::size_t i = 0; i < y.size(); ++i) {
      for (int k = pattern_.start[i]; k < pattern_.start[i + 1]; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const auto j = static_cast<std::size_t>(pattern_.column[at]);
        y[i] += value[at] * x[j];
        if (j != i) y[j] += value[at] * x[i];
      }
    }
    return y;
  }

  Vector diagonal(const Vector& value) const {
    Vector result(pattern_.rows());
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] = value[static_cast<std::size_t>(pattern_.start[i])];
    }
    return result;
  }

  void solve_one(const Vector& value, const Vector& b, Vector& x, double tolerance,
                 int most_iterations, CgReport& report) const {
    const Vector scale = diagonal(value);
    const double size = std::sqrt(dot(b, b));
    Vector r = product(value, x), p(x.size(), 0.0), z(x.size());
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = b[i] - r[i];
    double before = 0.0, residual = std::sqrt(dot(r, r));
    int iteration = 0;
    for (; iteration < most_iterations && residual > tolerance * size; ++iteration) {
      for (std::size_t i = 0; i < z.size(); ++i) z[i] = r[i] / scale[i];
      const double r_z = dot(r, z), along = iteration == 0 ? 0.0 : r_z / before;
      for (std::size_t i = 0; i < p.size(); ++i) p[i] = z[i] + along * p[i];
      const Vector image = product(value, p);
      const double step = r_z / dot(p, image);
      for (std::size_t i = 0; i < x.size(); ++i) {
        x[i] += step * p[i];
        r[i] -= step * image[i];
      }
      before = r_z;
      residual = std::sqrt(dot(r, r));
    }
    report.iterations = std::max(report.iterations, iteration);
    report.residual.push_back(size > 0.0 ? residual / size : 0.0);
    report.converged = report.converged && residual <= tolerance * size;
  }

  const Pattern& pattern_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_reference_solver(const Equations& equations) {
  return std::make_unique<ReferenceSolver>(equations.matrix());
}

}  // namespace kappamu::forward::polygrid
