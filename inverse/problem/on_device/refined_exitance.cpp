#include "inverse/problem/on_device/refined_exitance.h"

#include "core/error.h"
#include "inverse/kernels/device_arithmetic.h"

namespace kappamu::inverse {

void set_split(forward::DiffusionOperator& finer, const SplitMedium& medium) {
  check(finer.on_device() != nullptr, "the finer grid has no device");
  forward::DeviceMedium& there = *finer.on_device();
  DeviceArithmetic arithmetic(there.context());
  const GridShape& fine = finer.space().shape;
  const GridShape& own = medium.own;
  const device::Buffer logs = arithmetic.take(2 * fine.cells());
  arithmetic.launch("split_voxels", {fine.cells(), 1, 64, 1}, fine.nx, fine.ny, fine.nz, own.nx,
                    own.ny, own.nz, medium.lower[0], medium.lower[1],
                    arithmetic.upload(medium.fields), logs);
  there.set(logs);
}

std::vector<double> restricted_exitance(forward::DiffusionOperator& finer,
                                        const std::vector<double>& light, int patterns,
                                        const FaceShape& fine, const FaceShape& own,
                                        const BatchedSolve& solve) {
  forward::DeviceMedium& there = *finer.on_device();
  DeviceArithmetic arithmetic(there.context());
  const std::size_t light_size = finer.light_size();
  const std::size_t faces = finer.exitance_size() / fine.cells();
  std::vector<double> all;
  device::Buffer lit;
  solve_batches(
      finer, patterns, solve,
      [&](int first, forward::BatchField& b) {
        const std::size_t values = static_cast<std::size_t>(b.patterns()) * light_size;
        lit = arithmetic.take(values);
        arithmetic.context().write(lit, light.data() + static_cast<std::size_t>(first) * light_size,
                                   values * sizeof(double));
        there.load(lit, b);
      },
      [&](int, const forward::BatchField& phi) {
        const std::size_t maps = static_cast<std::size_t>(phi.patterns()) * faces;
        const device::Buffer leaving = arithmetic.take(maps * fine.cells());
        const device::Buffer means = arithmetic.take(maps * own.cells());
        there.exitance(phi, lit, leaving);
        arithmetic.launch("restrict_maps", {maps * own.cells(), 1, 64, 1}, static_cast<int>(maps),
                          fine.nu, fine.nv, own.nu, own.nv, leaving, means);
        const std::vector<double> part = arithmetic.read(means, maps * own.cells());
        all.insert(all.end(), part.begin(), part.end());
      });
  return all;
}

}  // namespace kappamu::inverse
