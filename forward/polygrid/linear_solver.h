// Solvers of a polygrid's equations for several lights and media (colour channels) at once.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "forward/linear/linear_solver.h"
#include "forward/polygrid/equations/hierarchy.h"

namespace kappamu::forward::polygrid {

using linear::CgReport;
using linear::Load;

/// What comes from one solve() to the next: `moving` light is like the last ones, so that OpenCL
/// solvers keep some answers and start from a combination of them instead of from `x`; where media
/// have changed since, at least 19 parts in 20 of the error that this made are solved away.
enum class Lights { others, moving };

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// One per channel; to be called before solve() and whenever the media change.
  void set_media(std::vector<MediumValues> media) {
    media_ = std::move(media);
    media_changed({});
  }
  const std::vector<MediumValues>& media() const { return media_; }
  /// Calls change(channel, values), which may change the values of `rows`, sorted, and no others.
  template <class Change>
  void change_media(std::span<const int> rows, const Change& change) {
    for (std::size_t c = 0; c < media_.size(); ++c) change(c, media_[c]);
    media_changed(rows);
  }
  /// Solves A x = load for every light, by conjugate gradients from `x` [light][unknown] until the
  /// relative error in the energy norm √(xᵀA x) is at most `tolerance` by the solver's estimate,
  /// which `residual` has: in OpenCL √(rᵀM⁻¹r / loadᵀx), M⁻¹ being a V-cycle, whose last
  /// correction is then added; on the host ‖residual‖/‖load‖. An `x` of another size starts at
  /// zero.
  virtual CgReport solve(const std::vector<Load>& loads, std::vector<std::vector<double>>& x,
                         double tolerance, int most_iterations) = 0;

 protected:
  /// media() has other numbers in some rows; without any, in all.
  virtual void media_changed(std::span<const int> rows) = 0;

 private:
  std::vector<MediumValues> media_;
};

/// On the host's threads, by forward/linear with the levels of the hierarchy as row matrices. Keeps
/// references.
std::unique_ptr<LinearSolver> make_host_solver(const Equations& equations,
                                               const Hierarchy& hierarchy);

/// "reference" is the host's; other words name an OpenCL device as device::choose() takes them.
/// Without any OpenCL device "auto" is the host's. Keeps references.
std::unique_ptr<LinearSolver> make_linear_solver(const Equations& equations,
                                                 const Hierarchy& hierarchy,
                                                 const std::string& device,
                                                 Lights lights = Lights::others);

}  // namespace kappamu::forward::polygrid
