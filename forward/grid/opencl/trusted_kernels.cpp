#include "forward/grid/opencl/trusted_kernels.h"

#include "forward/grid/solver_self_test.h"

namespace kappamu::forward {

TrustedKernels::TrustedKernels(device::Context& context, const Format& format, Layout layout,
                               const OpenclOptions& options)
    : context_(context), format_(format), layout_(layout), options_(options) {}

const LaneKernels& TrustedKernels::operator()(int lanes) {
  if (options_.trust == Trust::verify && !made_.contains(lanes)) {
    const Verdict& verdict = solver_verdict(context_, options_.precision, lanes);
    if (!verdict.trusted) {
      throw device::DeviceError("device '" + context_.info().name +
                                "' fails its known-answer test (" + verdict.message +
                                "); use the device reference");
    }
  }
  return made_.try_emplace(lanes, context_, format_, layout_, lanes).first->second;
}

}  // namespace kappamu::forward
