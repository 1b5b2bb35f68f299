// PETSc's conjugate gradients with smoothed aggregation (GAMG) and with incomplete Cholesky, the
// latter on each rank's own block (https://petsc.org, KSPCG, PCGAMG, PCICC).
#include <petscksp.h>

#include <stdexcept>
#include <utility>

#include "bench/peers/peer.h"

namespace kappamu::peers {

namespace {

void call(PetscErrorCode code) {
  if (code != 0) throw std::runtime_error("PETSc failed with code " + std::to_string(code));
}

struct Setting {
  std::string name;
  std::vector<std::pair<std::string, std::string>> options;
};

const std::vector<Setting> gamg_settings{
    {"defaults", {{"-pc_type", "gamg"}}},
    {"threshold 0.02", {{"-pc_type", "gamg"}, {"-pc_gamg_threshold", "0.02"}}},
    {"threshold 0.02, Chebyshev with Jacobi",
     {{"-pc_type", "gamg"}, {"-pc_gamg_threshold", "0.02"}, {"-mg_levels_pc_type", "jacobi"}}},
    {"threshold 0.02, symmetric Gauss-Seidel",
     {{"-pc_type", "gamg"},
      {"-pc_gamg_threshold", "0.02"},
      {"-mg_levels_ksp_type", "richardson"},
      {"-mg_levels_ksp_max_it", "1"},
      {"-mg_levels_pc_type", "sor"}}},
};
const std::vector<Setting> icc_settings{
    {"no fill", {{"-pc_type", "bjacobi"}, {"-sub_pc_type", "icc"}}},
    {"one level of fill",
     {{"-pc_type", "bjacobi"}, {"-sub_pc_type", "icc"}, {"-sub_pc_factor_levels", "1"}}},
};

class Petsc final : public Peer {
 public:
  Petsc(const Problem& problem, std::vector<Setting> settings) : settings_(std::move(settings)) {
    const int rows = problem.local_rows(), first = problem.first_row();
    call(MatCreateAIJ(PETSC_COMM_WORLD, rows, rows, problem.rows(), problem.rows(), 7, nullptr, 2,
                      nullptr, &matrix_));
    for (int local = 0; local < rows; ++local) {
      const Row row = problem.row(local);
      const int number = first + local;
      call(MatSetValues(matrix_, 1, &number, row.count, row.columns.data(), row.values.data(),
                        INSERT_VALUES));
    }
    call(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY));
    call(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY));
    call(MatSetOption(matrix_, MAT_SPD, PETSC_TRUE));
    call(MatCreateVecs(matrix_, &x_, &b_));
  }
  ~Petsc() override {
    if (ksp_ != nullptr) KSPDestroy(&ksp_);
    VecDestroy(&b_);
    VecDestroy(&x_);
    MatDestroy(&matrix_);
  }
  Petsc(const Petsc&) = delete;
  Petsc& operator=(const Petsc&) = delete;

  std::vector<std::string> settings() const override { return names_of(settings_); }

  void set_up(int setting) override {
    if (ksp_ != nullptr) call(KSPDestroy(&ksp_));
    call(PetscOptionsClear(nullptr));
    for (const auto& [name, value] : settings_[static_cast<std::size_t>(setting)].options) {
      call(PetscOptionsSetValue(nullptr, name.c_str(), value.c_str()));
    }
    call(KSPCreate(PETSC_COMM_WORLD, &ksp_));
    call(KSPSetType(ksp_, KSPCG));
    call(KSPSetNormType(ksp_, KSP_NORM_UNPRECONDITIONED));
    call(KSPSetOperators(ksp_, matrix_, matrix_));
    call(KSPSetFromOptions(ksp_));
    call(KSPSetUp(ksp_));
    call(KSPSetUpOnBlocks(ksp_));
  }

  int solve(const std::vector<double>& b, double tolerance, std::vector<double>& phi) override {
    double* values = nullptr;
    call(VecGetArray(b_, &values));
    std::copy(b.begin(), b.end(), values);
    call(VecRestoreArray(b_, &values));
    call(KSPSetTolerances(ksp_, tolerance, 0.0, PETSC_DEFAULT, max_iterations));
    call(KSPSolve(ksp_, b_, x_));  // from zero unless told otherwise
    int iterations = 0;
    call(KSPGetIterationNumber(ksp_, &iterations));
    const double* result = nullptr;
    call(VecGetArrayRead(x_, &result));
    phi.assign(result, result + b.size());
    call(VecRestoreArrayRead(x_, &result));
    return iterations;
  }

 private:
  std::vector<Setting> settings_;
  Mat matrix_ = nullptr;
  Vec b_ = nullptr, x_ = nullptr;
  KSP ksp_ = nullptr;
};

}  // namespace

std::unique_ptr<Peer> make_petsc_gamg(const Problem& problem) {
  return std::make_unique<Petsc>(problem, gamg_settings);
}

std::unique_ptr<Peer> make_petsc_icc(const Problem& problem) {
  return std::make_unique<Petsc>(problem, icc_settings);
}

}  // namespace kappamu::peers
