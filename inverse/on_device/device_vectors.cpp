#include "inverse/on_device/device_vectors.h"

#include <utility>

namespace kappamu::inverse {

DeviceVectors::DeviceVectors(DeviceArithmetic& arithmetic, DeviceFunction& function,
                             const OptimiserState& state, const CoefficientPair& fields)
    : arithmetic_(arithmetic), function_(function), size_(function.size()) {
  device::Context& context = arithmetic_.context();
  const auto upload = [&](const auto& values, const device::Buffer& buffer) {
    context.write(buffer, values.data(), values.size() * sizeof(values.front()));
    return buffer;
  };
  here_.z = upload(state.z, take());
  gradient_ = upload(state.gradient, take());
  for (std::size_t k = 0; k < state.steps.size(); ++k) {
    pairs_.push_back(
        {upload(state.steps[k], take_floats()), upload(state.changes[k], take_floats())});
  }
  if (fields.log_mu.empty()) {
    here_.fields = take();
    function_.to_fields(here_.z, here_.fields);
  } else {
    here_.fields = arithmetic_.upload(fields);
  }
  direction_ = take();
}

void DeviceVectors::set_gradient(const OptimiserState& state) {
  arithmetic_.context().write(gradient_, state.gradient.data(), size_ * sizeof(double));
}

void DeviceVectors::adopt(DeviceVectors& before) {
  pairs_.clear();
  const int count = static_cast<int>(size_);
  const device::Buffer step = take(), change = take();
  for (Pair& pair : before.pairs_) {
    arithmetic_.each("widen", size_, pair.step, step);
    arithmetic_.each("widen", size_, pair.change, change);
    function_.adopt(before.function_, here_.fields, step, change);
    if (!(arithmetic_.reduce("dot_product", size_, 1, 0, count, step, change).front() > 0.0)) {
      continue;
    }
    arithmetic_.each("narrow", size_, step, pair.step);
    arithmetic_.each("narrow", size_, change, pair.change);
    pairs_.push_back(std::move(pair));
  }
  before.pairs_.clear();
}

template <class Values>
void DeviceVectors::download(const device::Buffer& buffer, Values& values) const {
  values.resize(size_);
  arithmetic_.context().read(buffer, values.data(), size_ * sizeof(values.front()));
}

void DeviceVectors::store(OptimiserState& state) const {
  download(here_.z, state.z);
  download(gradient_, state.gradient);
}

void DeviceVectors::store_pairs(OptimiserState& state) const {
  state.steps.resize(pairs_.size());
  state.changes.resize(pairs_.size());
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    download(pairs_[k].step, state.steps[k]);
    download(pairs_[k].change, state.changes[k]);
  }
}

CoefficientPair DeviceVectors::fields() const {
  return arithmetic_.download(here_.fields, size_ / 2);
}

double DeviceVectors::solve() {
  solved_here_ = true;
  return function_.value(here_.fields);
}

std::vector<double> DeviceVectors::products(std::size_t k) {
  const int count = static_cast<int>(size_);
  const std::size_t numbers = 4 * (k + 1) + 1;
  const device::Buffer sums = arithmetic_.take(numbers);
  for (std::size_t j = 0; j <= k; ++j) {
    arithmetic_.reduce_into(sums, 4 * j, "pair_products", size_, 4, 0, count, pairs_[j].step,
                            pairs_[j].change, pairs_[k].change, gradient_);
  }
  arithmetic_.reduce_into(sums, numbers - 1, "square", size_, 1, 0, count, pairs_[k].step);
  return arithmetic_.read(sums, numbers);
}

double DeviceVectors::set_direction(const Combination& of) {
  arithmetic_.each("set_scaled", size_, of.gradient, gradient_, direction_);
  for (std::size_t k = 0; k < of.steps.size(); ++k) {
    if (of.steps[k] == 0.0 && of.changes[k] == 0.0) continue;
    arithmetic_.each("add_pair", size_, of.steps[k], pairs_[k].step, of.changes[k],
                     pairs_[k].change, direction_);
  }
  ahead_ = {};
  return arithmetic_
      .reduce("dot_product", size_, 1, 0, static_cast<int>(size_), direction_, gradient_)
      .front();
}

DeviceVectors::Point DeviceVectors::moved(double length) {
  Point to{take(), take()};
  arithmetic_.each("move_along", size_, length, here_.z, direction_, to.z);
  function_.to_fields(to.z, to.fields);
  return to;
}

double DeviceVectors::amplitude() {
  ahead_ = moved(1.0);
  return arithmetic_
      .reduce("largest_difference", size_, 1, 1, static_cast<int>(size_), ahead_.fields,
              here_.fields)
      .front();
}

double DeviceVectors::value_at(double length) {
  trial_ = length == 1.0 && ahead_.z ? ahead_ : moved(length);
  solved_here_ = false;
  return function_.value(trial_.fields);
}

device::Buffer DeviceVectors::difference(const device::Buffer& a, const device::Buffer& b) const {
  const device::Buffer to = take_floats();
  arithmetic_.each("difference", size_, a, b, to);
  return to;
}

void DeviceVectors::accept() {
  ahead_ = {};
  const device::Buffer step = difference(trial_.z, here_.z);
  here_ = std::exchange(trial_, {});
  solved_here_ = true;
  const device::Buffer before = std::exchange(gradient_, take());
  function_.gradient(here_.fields, gradient_);
  pairs_.push_back({step, difference(gradient_, before)});
}

}  // namespace kappamu::inverse
