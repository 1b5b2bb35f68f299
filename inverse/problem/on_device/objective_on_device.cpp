// value() and gradient() of fields in the memory of the operator's device. Of data with independent
// Gaussian errors nothing but sums comes to the host.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "inverse/problem/objective.h"

namespace kappamu::inverse {

bool Objective::belong_on_device(double bytes, VectorPlace place) const {
  const forward::DeviceMedium* const medium = on_device();
  if (medium == nullptr || place == VectorPlace::host) return false;
  if (place == VectorPlace::device) return true;
  // A processor's own loops and transforms are faster there than kernels (docs/engine.md).
  const device::DeviceInfo& info = medium->context().info();
  // Beside them are the data, light and exitance, and while r is renewed the fields of the finer
  // grid, eight vectors a pattern.
  constexpr double data = 6.0 * sizeof(double), finer_voxels = 8.0, vectors = 8.0, share = 0.85;
  const double number = backend_.precision == forward::Precision::single_precision ? 4.0 : 8.0;
  const auto cells = static_cast<double>(space().cells());
  const double finer = std::min(backend_.refined_memory_mb * 1048576.0,
                                finer_voxels * cells * vectors * number * backend_.batch);
  const double needed = bytes + data * static_cast<double>(problem_.data.size()) + finer;
  return info.kind == device::Kind::gpu &&
         static_cast<double>(medium->context().allocated_bytes()) + needed <=
             share * static_cast<double>(info.global_memory_bytes);
}

DeviceData& Objective::device_data() {
  if (!device_data_) {
    device_data_ = std::make_unique<DeviceData>(on_device()->context(), light_, views_.lights(),
                                                backend_.batch, operator_->exitance_size());
  }
  return *device_data_;
}

/// Whether the data term is DeviceData's.
bool Objective::misfit_on_device() const {
  return data_options_.loss == Loss::gaussian && !shares_errors(problem_, data_options_) &&
         views_.faces().list.size() == 1 && correction_.slope[0].empty() &&
         correction_.slope[1].empty();
}

/// Exitance stays there.
bool Objective::solve_on_device(const device::Buffer& logs) {
  forward::DeviceMedium& medium = *on_device();
  medium.set(logs);
  const DeviceData& there = device_data();
  return solve_lights(
      [&](std::size_t part, forward::BatchField& b) { medium.load(there[part].light, b); },
      [&](std::size_t part, const forward::BatchField& phi) {
        medium.exitance(phi, there[part].light, there[part].exitance);
      });
}

double Objective::value(const device::Buffer& logs, const LogRange& range) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  fluence_.clear();
  fields_ = {};
  if (!(range.largest <= max_log_coefficient)) return infinite;
  device_means_ = range.mean;
  if (!solve_on_device(logs)) return infinite;
  seen_here_ = false;
  if (!misfit_on_device()) {
    see_device();
    return misfit();
  }
  if (!data_on_device_) {
    device_data_->set_data(problem_.data, problem_.weight, correction_.ratio);
    used_ = problem_.used();
    data_on_device_ = true;
  }
  const double squares = device_data_->misfit();
  data_term_.value = std::isfinite(squares) ? 0.5 * squares : infinite;
  data_term_.chi2_per_value = squares / static_cast<double>(std::max<std::size_t>(1, used_));
  return data_term_.value;
}

/// The exitance of the last value(), read.
void Objective::see_device() {
  leaving_ = device_data_->exitance();
  see();
}

void Objective::came_from(CoefficientPair fields) {
  fields_ = std::move(fields);
  if (seen_here_) return;
  see_device();
  misfit();
}

void Objective::gradient(const device::Buffer& by_logs) {
  device::Context& context = on_device()->context();
  const std::size_t cells = space().cells(), bytes = 2 * cells * sizeof(double);
  std::array<double, 2> even{};
  if (seen_here_) {
    const std::vector<double> slopes = by_exitance();
    even = even_gradient(slopes);
    device_data_->set_by_exitance(views_.exitance(slopes));
  }
  if (even == std::array<double, 2>{}) {
    context.zero(by_logs, bytes);
  } else {
    context.fill(by_logs, bytes, [&](void* memory) {
      for (std::size_t k = 0; k < 2; ++k) {
        std::fill_n(static_cast<double*>(memory) + k * cells, cells, even[k]);
      }
    });
  }
  adjoint_on_device(by_logs);
}

/// Adds the gradient by logarithms, from the derivatives by exitance that are there.
void Objective::adjoint_on_device(const device::Buffer& by_logs) {
  forward::DeviceMedium& medium = *on_device();
  const DeviceData& there = device_data();
  solve_adjoint(
      [&](std::size_t part, forward::BatchField& b) {
        medium.exitance_transpose(there[part].by_exitance, b);
      },
      [&](std::size_t part, const forward::BatchField& lambda) {
        medium.add_gradient({*fluence_[part], there[part].light, there[part].exitance}, lambda,
                            there[part].by_exitance, by_logs);
      });
}

}  // namespace kappamu::inverse
