#include "studies/peers/pfmg.h"

namespace kappamu::peers {

Pfmg::Pfmg(const Problem& problem) : lower_(problem.lower()), upper_(problem.upper()) {
  HYPRE_StructGridCreate(MPI_COMM_WORLD, 3, &grid_);
  HYPRE_StructGridSetExtents(grid_, lower_.data(), upper_.data());
  HYPRE_StructGridAssemble(grid_);
  // Symmetric storage: the centre and the three forward neighbours.
  HYPRE_StructStencilCreate(3, 4, &stencil_);
  int offsets[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int e = 0; e < 4; ++e) HYPRE_StructStencilSetElement(stencil_, e, offsets[e]);
  HYPRE_StructMatrixCreate(MPI_COMM_WORLD, grid_, stencil_, &matrix_);
  HYPRE_StructMatrixSetSymmetric(matrix_, 1);
  HYPRE_StructMatrixInitialize(matrix_);
  std::vector<double> values;
  for (int local = 0; local < problem.local_rows(); ++local) {
    const auto row = problem.upper_row(local);
    values.insert(values.end(), row.begin(), row.end());
  }
  int entries[4] = {0, 1, 2, 3};
  HYPRE_StructMatrixSetBoxValues(matrix_, lower_.data(), upper_.data(), 4, entries, values.data());
  HYPRE_StructMatrixAssemble(matrix_);
  for (HYPRE_StructVector* vector : {&b_, &x_}) {
    HYPRE_StructVectorCreate(MPI_COMM_WORLD, grid_, vector);
    HYPRE_StructVectorInitialize(*vector);
    HYPRE_StructVectorAssemble(*vector);
  }
}

Pfmg::~Pfmg() {
  forget_solver();
  HYPRE_StructVectorDestroy(b_);
  HYPRE_StructVectorDestroy(x_);
  HYPRE_StructMatrixDestroy(matrix_);
  HYPRE_StructStencilDestroy(stencil_);
  HYPRE_StructGridDestroy(grid_);
}

void Pfmg::set_up(const Setting& setting) {
  forget_solver();
  HYPRE_StructPFMGCreate(MPI_COMM_WORLD, &pfmg_);
  HYPRE_StructPFMGSetMaxIter(pfmg_, 1);
  HYPRE_StructPFMGSetTol(pfmg_, 0.0);
  HYPRE_StructPFMGSetZeroGuess(pfmg_);
  HYPRE_StructPFMGSetRelaxType(pfmg_, setting.relax_type);
  HYPRE_StructPFMGSetRAPType(pfmg_, setting.rap_type);
  HYPRE_StructPFMGSetSkipRelax(pfmg_, setting.skip_relax);
  HYPRE_StructPFMGSetNumPreRelax(pfmg_, 1);
  HYPRE_StructPFMGSetNumPostRelax(pfmg_, 1);
  HYPRE_StructPCGCreate(MPI_COMM_WORLD, &pcg_);
  HYPRE_StructPCGSetMaxIter(pcg_, max_iterations);
  HYPRE_StructPCGSetTwoNorm(pcg_, 1);
  HYPRE_StructPCGSetPrecond(pcg_, HYPRE_StructPFMGSolve, HYPRE_StructPFMGSetup, pfmg_);
  HYPRE_StructPCGSetup(pcg_, matrix_, b_, x_);
}

int Pfmg::solve(const std::vector<double>& b, double tolerance, std::vector<double>& phi) {
  set(b_, b);
  phi.assign(b.size(), 0.0);
  set(x_, phi);
  HYPRE_StructPCGSetTol(pcg_, tolerance);
  HYPRE_StructPCGSolve(pcg_, matrix_, b_, x_);
  HYPRE_ClearAllErrors();  // a tolerance out of reach is the caller's to see in φ
  int iterations = 0;
  HYPRE_StructPCGGetNumIterations(pcg_, &iterations);
  HYPRE_StructVectorGetBoxValues(x_, lower_.data(), upper_.data(), phi.data());
  return iterations;
}

void Pfmg::set(HYPRE_StructVector vector, const std::vector<double>& values) {
  HYPRE_StructVectorSetBoxValues(vector, lower_.data(), upper_.data(),
                                 const_cast<double*>(values.data()));
  HYPRE_StructVectorAssemble(vector);
}

void Pfmg::forget_solver() {
  if (pcg_ != nullptr) HYPRE_StructPCGDestroy(pcg_);
  if (pfmg_ != nullptr) HYPRE_StructPFMGDestroy(pfmg_);
  pcg_ = pfmg_ = nullptr;
}

}  // namespace kappamu::peers
