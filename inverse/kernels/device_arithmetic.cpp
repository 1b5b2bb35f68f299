#include "inverse/kernels/device_arithmetic.h"

#include <algorithm>

#include "forward/device_medium.h"

namespace kappamu::inverse {

extern const device::KernelSource fit_cl;

DeviceArithmetic::DeviceArithmetic(device::Context& context)
    : context_(context), program_(context.program(fit_cl, "")), pool_(context) {}

device::Buffer DeviceArithmetic::upload(const CoefficientPair& fields) {
  const std::size_t cells = fields.log_mu.size();
  device::Buffer both = take(2 * cells);
  context_.fill(both, 2 * cells * sizeof(double), [&](void* memory) {
    auto* const values = static_cast<double*>(memory);
    std::copy(fields.log_kappa.begin(), fields.log_kappa.end(), values);
    std::copy(fields.log_mu.begin(), fields.log_mu.end(), values + cells);
  });
  return both;
}

CoefficientPair DeviceArithmetic::download(const device::Buffer& fields, std::size_t cells) const {
  return forward::read_pair(context_, fields, cells);
}

std::vector<double> DeviceArithmetic::read(const device::Buffer& numbers, std::size_t count) const {
  std::vector<double> values(count);
  context_.read(numbers, values.data(), count * sizeof(double));
  return values;
}

}  // namespace kappamu::inverse
