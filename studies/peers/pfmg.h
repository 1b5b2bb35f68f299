// hypre's Struct interface: PFMG, a semicoarsening multigrid for just our kind of matrix, as
// preconditioner of its conjugate gradients (https://hypre.readthedocs.io, "PFMG").
#pragma once

#include <HYPRE_struct_ls.h>

#include <array>
#include <vector>

#include "studies/peers/problem.h"

namespace kappamu::peers {

/// What its manual suggests to try.
struct Setting {
  const char* name;
  int relax_type;  ///< 1 weighted Jacobi, 2 red/black Gauss-Seidel, symmetric
  int rap_type;    ///< 0 Galerkin, 1 non-Galerkin seven-point
  int skip_relax;  ///< 1: no relaxation on levels where semicoarsening makes it needless
};
inline constexpr std::array<Setting, 5> settings{{
    {"weighted Jacobi, Galerkin, skip", 1, 0, 1},
    {"red-black Gauss-Seidel, Galerkin, skip", 2, 0, 1},
    {"red-black Gauss-Seidel, Galerkin", 2, 0, 0},
    {"red-black Gauss-Seidel, non-Galerkin, skip", 2, 1, 1},
    {"red-black Gauss-Seidel, non-Galerkin", 2, 1, 0},
}};

inline constexpr int max_iterations = 5000;

class Pfmg {
 public:
  /// Assembles the matrix.
  explicit Pfmg(const Problem& problem);
  ~Pfmg();
  Pfmg(const Pfmg&) = delete;
  Pfmg& operator=(const Pfmg&) = delete;

  /// Builds the preconditioner: only this is timed as set-up.
  void set_up(const Setting& setting);
  /// Conjugate gradients from zero to ‖b − Aφ‖₂ ≤ tolerance ‖b‖₂. Returns the iterations. Vectors
  /// in row order, this rank's part.
  int solve(const std::vector<double>& b, double tolerance, std::vector<double>& phi);

 private:
  void set(HYPRE_StructVector vector, const std::vector<double>& values);
  void forget_solver();

  std::array<int, 3> lower_, upper_;
  HYPRE_StructGrid grid_ = nullptr;
  HYPRE_StructStencil stencil_ = nullptr;
  HYPRE_StructMatrix matrix_ = nullptr;
  HYPRE_StructVector b_ = nullptr, x_ = nullptr;
  HYPRE_StructSolver pcg_ = nullptr, pfmg_ = nullptr;
};

}  // namespace kappamu::peers
