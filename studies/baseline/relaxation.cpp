#include "studies/baseline/relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/shown_text.h"
#include "forward/grid/rounding_floor.h"

namespace kappamu::studies::baseline {

namespace {

/// Nothing is gained when four checks in a row, a quarter more sweeps, gain less than this...
constexpr double least_gain = 1e-4;
constexpr int idle_checks = 4;
/// ... and it is rounding's doing where no residual is above so many times the one it can hide.
/// Elsewhere it is a plateau: light has yet to cross a gap or a bright inclusion.
/// Measured where sweeps end: 0.4 to 0.6 by Gauss-Seidel, up to 4 by Jacobi on long pipes; 10⁴ and
/// more on plateaus.
constexpr double floor_reach = 16.0;

class Sweeper {
 public:
  Sweeper(const Batch& batch, Relaxation kind, const DeviceStencil& s, const Active& active,
          const device::Buffer& b)
      : batch_(batch), kind_(kind), s_(s), active_(active), b_(b) {
    partial_ = batch.make_partial_sums();
  }

  void sweep(device::Buffer& phi, device::Buffer& other) const {
    const int depth = active_.depth;
    const int open_x = active_.open[0], open_y = active_.open[1], open_z = active_.open[2];
    if (kind_ == Relaxation::jacobi) {
      batch_.sweep("jacobi", s_.n, s_.gx, s_.gy, s_.gz, s_.sink, s_.inverse, depth, open_x, open_y,
                   open_z, b_, phi, other);
      std::swap(phi, other);
      return;
    }
    for (const int colour : {0, 1}) {
      batch_.sweep("gauss_seidel", s_.n, s_.gx, s_.gy, s_.gz, s_.sink, s_.inverse, depth, open_x,
                   open_y, open_z, colour, b_, phi);
    }
  }

  /// ‖b − A φ‖ of each pattern over the active cells.
  std::vector<double> norms(const device::Buffer& phi, const Active& active) const {
    const int open_x = active.open[0], open_y = active.open[1], open_z = active.open[2];
    batch_.over_runs("residual_norm", s_.n[0], s_.n[1], s_.n[2], s_.gx, s_.gy, s_.gz, s_.sink,
                     active.depth, open_x, open_y, open_z, batch_.runs(), b_, phi, partial_);
    return roots();
  }

  /// u ‖(ΣG + S) φ‖ of each pattern over the active cells, u half a unit in the last place: an
  /// increment r_i/(ΣG + S)_i below u φ_i is rounded away.
  std::vector<double> hidden_norms(const device::Buffer& phi) const {
    const double u = 0.5 * (batch_.precision() == Precision::single_precision
                                ? static_cast<double>(std::numeric_limits<float>::epsilon())
                                : std::numeric_limits<double>::epsilon());
    const int open_x = active_.open[0], open_y = active_.open[1], open_z = active_.open[2];
    batch_.over_runs("diagonal_norm", s_.n[0], s_.n[1], s_.n[2], s_.inverse, active_.depth, open_x,
                     open_y, open_z, batch_.runs(), phi, partial_);
    std::vector<double> norms = roots();
    for (double& norm : norms) norm *= u;
    return norms;
  }

 private:
  std::vector<double> roots() const {
    std::vector<double> norms = batch_.sum(partial_);
    norms.resize(static_cast<std::size_t>(batch_.patterns()));
    for (double& norm : norms) norm = std::sqrt(norm);
    return norms;
  }

  const Batch& batch_;
  Relaxation kind_;
  const DeviceStencil& s_;
  Active active_;
  const device::Buffer& b_;
  device::Buffer partial_;
};

}  // namespace

Relaxed relax(const Batch& batch, Relaxation kind, const DeviceStencil& stencil,
              const Active& active, const device::Buffer& b, device::Buffer& phi,
              const SolveOptions& options) {
  const Sweeper sweeper(batch, kind, stencil, active, b);
  // A zero field's residual is b itself.
  device::Buffer other = batch.make_field(stencil.cells());
  const std::vector<double> norm_b = sweeper.norms(other, {});
  // Jacobi swaps the two buffers; cells at rest must be the same in both.
  batch.context().copy(phi, other, phi.bytes());

  Relaxed result;
  const auto check = [&] {
    result.residual = sweeper.norms(phi, active);
    for (std::size_t m = 0; m < norm_b.size(); ++m) {
      result.residual[m] = norm_b[m] > 0.0 ? result.residual[m] / norm_b[m] : result.residual[m];
    }
    return *std::max_element(result.residual.begin(), result.residual.end());
  };
  const auto rounding_hides_the_rest = [&] {
    const std::vector<double> hidden = sweeper.hidden_norms(phi);
    for (std::size_t m = 0; m < norm_b.size(); ++m) {
      const double reach = floor_reach * hidden[m] / (norm_b[m] > 0.0 ? norm_b[m] : 1.0);
      if (result.residual[m] > std::max(options.tolerance, reach)) return false;
    }
    return true;
  };
  double worst = check(), best = worst;
  int idle = 0;
  while (worst > options.tolerance && result.sweeps < options.max_iterations && !result.stalled) {
    const int next =
        std::min(options.max_iterations, result.sweeps + std::max(8, result.sweeps / 16));
    const int count = next - result.sweeps;
    for (; result.sweeps < next; ++result.sweeps) sweeper.sweep(phi, other);
    const double before = worst;
    worst = check();
    result.factor = std::pow(worst / before, 1.0 / count);
    idle = worst < (1.0 - least_gain) * best ? 0 : idle + 1;
    best = std::min(best, worst);
    result.stalled = worst > options.tolerance && idle >= idle_checks && rounding_hides_the_rest();
  }
  result.converged = worst <= options.tolerance;
  return result;
}

std::string sentence(const Relaxed& relaxed, double tolerance, Precision precision) {
  const double worst = *std::max_element(relaxed.residual.begin(), relaxed.residual.end());
  std::string text = formatted("relative residual %g after %d sweeps", worst, relaxed.sweeps);
  if (relaxed.converged) return text;
  text += formatted(", tolerance %g not met: ", tolerance);
  if (!std::isfinite(worst)) return text + "not a number, the light is not finite";
  if (relaxed.stalled) return text + "stalled, " + rounding_floor_sentence(precision);
  if (relaxed.factor < 1.0) {
    const double more = std::log(tolerance / worst) / std::log(relaxed.factor);
    return text + formatted("a sweep lowers it by only %g %%, so that at least %g more are needed",
                            100.0 * (1.0 - relaxed.factor), std::ceil(more));
  }
  text += "the last sweeps did not lower it, light has yet to cross the block";
  if (precision == Precision::single_precision) {
    text += ", or rounding grows: compare with --precision double";
  }
  return text;
}

}  // namespace kappamu::studies::baseline
