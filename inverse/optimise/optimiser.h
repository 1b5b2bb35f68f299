// One step of minimisation at a time, with all that the next step needs in a
// plain state, so that a fit can be stopped anywhere and resumed to the same
// bits.
#pragma once

#include <functional>
#include <vector>

#include "core/names.h"
#include "inverse/optimise/basis.h"

namespace kappamu::inverse {

/// The function f(z) that is minimised.
class Function {
 public:
  virtual ~Function() = default;
  virtual double value(const Vector& z) = 0;
  virtual Vector gradient() = 0;  ///< at the z of the last value()
  /// Largest change of log κ or log μ from z to z + `direction` [log units].
  virtual double amplitude(const Vector& z, const Vector& direction) = 0;
  /// Of a product of vectors, where this process holds `part` of them: the whole product.
  virtual double total(double part) const { return part; }
};

enum class Method {
  lbfgs,    ///< limited-memory BFGS with Armijo backtracking
  wang2008  ///< [W] Table I: Polak-Ribière conjugate gradients, golden-section search
};
inline constexpr Names<Method, 2> method_names{
    {{"lbfgs", Method::lbfgs}, {"wang2008", Method::wang2008}}};

struct OptimiserOptions {
  Method method = Method::lbfgs;
  int memory = 12;                ///< L-BFGS pairs kept
  double first_step = 0.5;        ///< change of log κ or log μ in the first step
  double longest_step = 2.0;      ///< and in any step
  int max_backtracks = 12;        ///< halvings of a step before the search gives up
  double golden_tolerance = 0.1;  ///< final width of the bracket over the step found
};

/// Products of one L-BFGS pair: step · change, and both squares.
struct LbfgsProducts {
  double curvature = 0.0;
  double step_square = 0.0;
  double change_square = 0.0;
};

struct OptimiserState {
  Vector z;
  double value = 0.0;  ///< f(z)
  Vector gradient;     ///< at z
  /// L-BFGS pairs, oldest first: steps and changes of the gradient.
  std::vector<std::vector<float>> steps;
  std::vector<std::vector<float>> changes;
  std::vector<LbfgsProducts> products;
  Vector direction;          ///< conjugate gradients: the last direction
  Vector previous_gradient;  ///< conjugate gradients: the gradient it was made of
  double previous_step = 0.0;
};

enum class StepOutcome { progressed, stalled };

/// Evaluates f at state.z and forgets all about earlier steps.
void start(Function& function, OptimiserState& state);

/// An L-BFGS pair of one function and its coordinates made one of another's.
using PairTranslation = std::function<void(Vector& step, Vector& change)>;
/// The same, but keeps the pairs, translated by `translate`; those whose curvature it leaves
/// negative are dropped.
void restart(Function& function, OptimiserState& state, const PairTranslation& translate);

/// One step from state.z, where start() or the last step evaluated f.
/// `stalled`: no lower value was found along the search direction; the state is
/// as before.
StepOutcome step(Function& function, OptimiserState& state, const OptimiserOptions& options);

}  // namespace kappamu::inverse
