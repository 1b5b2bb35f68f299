// hypre's algebraic multigrid as preconditioner of its conjugate gradients
// (https://hypre.readthedocs.io, "BoomerAMG").
#include <HYPRE.h>
#include <HYPRE_krylov.h>
#include <HYPRE_parcsr_ls.h>

#include <numeric>

#include "bench/peers/peer.h"

namespace kappamu::peers {

namespace {

struct Setting {
  const char* name;
  double strong_threshold;
  int aggressive_levels;
};
constexpr Setting choices[] = {
    {"HMIS, threshold 0.25", 0.25, 0},
    {"HMIS, threshold 0.5, one aggressive level", 0.5, 1},
};

class BoomerAmg final : public Peer {
 public:
  explicit BoomerAmg(const Problem& problem) : rows_(problem.local_rows()) {
    const int first = problem.first_row(), last = first + rows_ - 1;
    indices_.resize(static_cast<std::size_t>(rows_));
    std::iota(indices_.begin(), indices_.end(), first);
    HYPRE_IJMatrixCreate(MPI_COMM_WORLD, first, last, first, last, &matrix_);
    HYPRE_IJMatrixSetObjectType(matrix_, HYPRE_PARCSR);
    HYPRE_IJMatrixInitialize(matrix_);
    for (int local = 0; local < rows_; ++local) {
      Row row = problem.row(local);
      const int number = first + local;
      HYPRE_IJMatrixSetValues(matrix_, 1, &row.count, &number, row.columns.data(),
                              row.values.data());
    }
    HYPRE_IJMatrixAssemble(matrix_);
    HYPRE_IJMatrixGetObject(matrix_, reinterpret_cast<void**>(&parcsr_));
    for (HYPRE_IJVector* vector : {&b_, &x_}) {
      HYPRE_IJVectorCreate(MPI_COMM_WORLD, first, last, vector);
      HYPRE_IJVectorSetObjectType(*vector, HYPRE_PARCSR);
      HYPRE_IJVectorInitialize(*vector);
      HYPRE_IJVectorAssemble(*vector);
    }
    HYPRE_IJVectorGetObject(b_, reinterpret_cast<void**>(&par_b_));
    HYPRE_IJVectorGetObject(x_, reinterpret_cast<void**>(&par_x_));
  }
  ~BoomerAmg() override {
    forget_solver();
    HYPRE_IJVectorDestroy(b_);
    HYPRE_IJVectorDestroy(x_);
    HYPRE_IJMatrixDestroy(matrix_);
  }
  BoomerAmg(const BoomerAmg&) = delete;
  BoomerAmg& operator=(const BoomerAmg&) = delete;

  std::vector<std::string> settings() const override { return names_of(choices); }

  void set_up(int setting) override {
    forget_solver();
    const Setting& choice = choices[setting];
    HYPRE_BoomerAMGCreate(&amg_);
    HYPRE_BoomerAMGSetMaxIter(amg_, 1);
    HYPRE_BoomerAMGSetTol(amg_, 0.0);
    HYPRE_BoomerAMGSetCoarsenType(amg_, 10);  // HMIS
    HYPRE_BoomerAMGSetInterpType(amg_, 6);    // extended+i
    HYPRE_BoomerAMGSetPMaxElmts(amg_, 4);
    HYPRE_BoomerAMGSetRelaxType(amg_, 8);  // l1 symmetric Gauss-Seidel
    HYPRE_BoomerAMGSetNumSweeps(amg_, 1);
    HYPRE_BoomerAMGSetStrongThreshold(amg_, choice.strong_threshold);
    HYPRE_BoomerAMGSetAggNumLevels(amg_, choice.aggressive_levels);
    HYPRE_ParCSRPCGCreate(MPI_COMM_WORLD, &pcg_);
    HYPRE_PCGSetMaxIter(pcg_, max_iterations);
    HYPRE_PCGSetTwoNorm(pcg_, 1);
    HYPRE_PCGSetPrecond(pcg_, reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSolve),
                        reinterpret_cast<HYPRE_PtrToSolverFcn>(HYPRE_BoomerAMGSetup), amg_);
    HYPRE_ParCSRPCGSetup(pcg_, parcsr_, par_b_, par_x_);
  }

  int solve(const std::vector<double>& b, double tolerance, std::vector<double>& phi) override {
    phi.assign(b.size(), 0.0);
    HYPRE_IJVectorSetValues(b_, rows_, indices_.data(), b.data());
    HYPRE_IJVectorSetValues(x_, rows_, indices_.data(), phi.data());
    HYPRE_PCGSetTol(pcg_, tolerance);
    HYPRE_ParCSRPCGSolve(pcg_, parcsr_, par_b_, par_x_);
    HYPRE_ClearAllErrors();  // a tolerance out of reach is the caller's to see in φ
    int iterations = 0;
    HYPRE_PCGGetNumIterations(pcg_, &iterations);
    HYPRE_IJVectorGetValues(x_, rows_, indices_.data(), phi.data());
    return iterations;
  }

 private:
  void forget_solver() {
    if (pcg_ != nullptr) HYPRE_ParCSRPCGDestroy(pcg_);
    if (amg_ != nullptr) HYPRE_BoomerAMGDestroy(amg_);
    pcg_ = amg_ = nullptr;
  }

  int rows_;
  std::vector<int> indices_;
  HYPRE_IJMatrix matrix_ = nullptr;
  HYPRE_ParCSRMatrix parcsr_ = nullptr;
  HYPRE_IJVector b_ = nullptr, x_ = nullptr;
  HYPRE_ParVector par_b_ = nullptr, par_x_ = nullptr;
  HYPRE_Solver pcg_ = nullptr, amg_ = nullptr;
};

}  // namespace

std::unique_ptr<Peer> make_hypre_boomeramg(const Problem& problem) {
  return std::make_unique<BoomerAmg>(problem);
}

}  // namespace kappamu::peers
