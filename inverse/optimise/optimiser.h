// One step of minimisation at a time, with all that the next step needs in a
// plain state, so that a fit can be stopped anywhere and resumed to the same
// bits.
#pragma once

#include <functional>
#include <span>
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
  /// Makes products of vectors, of which this process holds a part, those of the whole vectors.
  virtual void total(std::span<double> /*products*/) const {}
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

/// Inner products of one L-BFGS pair.
struct LbfgsProducts {
  double step_square = 0.0;
  /// Of its change with the steps and changes of the pairs from the oldest to itself.
  std::vector<double> by_step, by_change;

  double curvature() const { return by_step.back(); }
  double change_square() const { return by_change.back(); }
};

struct OptimiserState {
  Vector z;
  double value = 0.0;  ///< f(z)
  Vector gradient;     ///< at z
  /// L-BFGS pairs, oldest first: steps and changes of the gradient.
  std::vector<std::vector<float>> steps;
  std::vector<std::vector<float>> changes;
  /// Of the pairs, oldest first, as far as they are known; the next direction completes them.
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
