#include "inverse/on_device/steps.h"

#include <utility>

#include "core/error.h"
#include "inverse/on_device/device_vectors.h"

namespace kappamu::inverse {

namespace {

/// Bytes of the vectors on the device for each voxel, with so many pairs of L-BFGS.
std::size_t bytes_per_voxel(int pairs) {
  // Two coefficients: pairs in float; z, its gradient and direction, two points of z and fields,
  // the gradient by the fields and two scratch vectors of the transforms in double.
  constexpr std::size_t doubles = 12;
  return 2 * (2 * sizeof(float) * static_cast<std::size_t>(pairs) + sizeof(double) * doubles);
}

/// Whether the vectors belong into the memory of the device that the operator computes on.
bool belong_there(const Objective& objective, const Basis& basis, const Regulariser& regulariser,
                  const OptimiserOptions& options, VectorPlace place) {
  const bool possible = options.method == Method::lbfgs && basis.waves() != nullptr &&
                        regulariser.kind != RegulariserKind::wang2008;
  const std::size_t bytes = objective.space().cells() * bytes_per_voxel(options.memory);
  return possible && objective.belong_on_device(static_cast<double>(bytes), place);
}

}  // namespace

struct Steps::OnDevice {
  DeviceArithmetic arithmetic;
  DeviceFunction function;
  DeviceVectors vectors;

  OnDevice(Objective& objective, const Basis& basis, const FitFunction& of,
           const OptimiserState& state)
      : arithmetic(objective.on_device()->context()),
        function(arithmetic, objective, basis,
                 {of.anchor(), of.weight(), of.regulariser(), of.scale()}),
        vectors(arithmetic, function, state, of.start_fields(state.z)) {}
};

Steps::Steps(Objective& objective, const Basis& basis, FitFunction& function, OptimiserState& state,
             const OptimiserOptions& options, VectorPlace place)
    : objective_(objective), function_(function), state_(state), options_(options) {
  if (belong_there(objective, basis, function.regulariser(), options, place)) {
    device_ = std::make_unique<OnDevice>(objective, basis, function, state);
    state.steps = state.changes = {};
  }
}

Steps::~Steps() = default;

StepOutcome Steps::step() {
  if (!device_) return inverse::step(function_, state_, options_);
  return lbfgs_step(device_->vectors, state_.value, state_.products, options_);
}

void Steps::solve() {
  if (device_) {
    device_->vectors.solve();
  } else {
    function_.value(state_.z);
  }
}

double Steps::roughness() const {
  return device_ ? device_->function.roughness() : function_.last_roughness();
}

CoefficientPair Steps::fields() const {
  return device_ ? device_->vectors.fields() : function_.here();
}

void Steps::store() const {
  if (!device_) return;
  device_->vectors.store(state_);
  device_->vectors.store_pairs(state_);
}

void Steps::go_on() {
  if (device_) device_->vectors.set_gradient(state_);
}

void Steps::adopt(Steps& before) {
  check(device_ && before.device_, "pairs are adopted on the device");
  device_->vectors.adopt(before.device_->vectors);
}

void Steps::leave() {
  if (!device_) return;
  device_->vectors.store(state_);
  CoefficientPair fields = device_->vectors.fields();
  if (device_->vectors.solved_here()) objective_.came_from(fields);
  function_.come_to(state_.z, std::move(fields));
}

}  // namespace kappamu::inverse
