// Eigen's conjugate gradients with its incomplete Cholesky factorisation; serial.
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include "bench/peers/peer.h"

namespace kappamu::peers {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
template <class Ordering>
using Iccg = Eigen::ConjugateGradient<Matrix, Eigen::Lower,
                                      Eigen::IncompleteCholesky<double, Eigen::Lower, Ordering>>;

class EigenIccg final : public Peer {
 public:
  explicit EigenIccg(const Problem& problem) : matrix_(problem.rows(), problem.rows()) {
    matrix_.reserve(Eigen::VectorXi::Constant(problem.rows(), 7));
    for (int i = 0; i < problem.rows(); ++i) {
      const Row row = problem.row(i);  // symmetric: rows are columns
      for (int e = 0; e < row.count; ++e) {
        const auto at = static_cast<std::size_t>(e);
        matrix_.insert(row.columns[at], i) = row.values[at];
      }
    }
    matrix_.makeCompressed();
  }

  std::vector<std::string> settings() const override {
    return {"natural order", "approximate minimum degree order"};
  }

  void set_up(int setting) override {
    reordered_ = setting == 1;
    if (reordered_) {
      by_degree_.compute(matrix_);
    } else {
      natural_.compute(matrix_);
    }
  }

  int solve(const std::vector<double>& b, double tolerance, std::vector<double>& phi) override {
    return reordered_ ? solve(by_degree_, b, tolerance, phi) : solve(natural_, b, tolerance, phi);
  }

 private:
  template <class Solver>
  static int solve(Solver& solver, const std::vector<double>& b, double tolerance,
                   std::vector<double>& phi) {
    solver.setTolerance(tolerance);
    solver.setMaxIterations(max_iterations);
    const auto size = static_cast<Eigen::Index>(b.size());
    phi.resize(b.size());
    Eigen::Map<Eigen::VectorXd>(phi.data(), size) =
        solver.solve(Eigen::Map<const Eigen::VectorXd>(b.data(), size));
    return static_cast<int>(solver.iterations());
  }

  Matrix matrix_;
  Iccg<Eigen::NaturalOrdering<int>> natural_;
  Iccg<Eigen::AMDOrdering<int>> by_degree_;
  bool reordered_ = false;
};

}  // namespace

std::unique_ptr<Peer> make_eigen_iccg(const Problem& problem) {
  return std::make_unique<EigenIccg>(problem);
}

}  // namespace kappamu::peers
