#include "inverse/on_device/device_function.h"

#include <cmath>
#include <vector>

#include "core/error.h"

namespace kappamu::inverse {

namespace {

/// Of log μ, on squared differences of log κ's factor.
constexpr double per_mu = 1.0 / (absorbers_vary * absorbers_vary);

}  // namespace

DeviceFunction::DeviceFunction(DeviceArithmetic& arithmetic, Objective& objective,
                               const Basis& basis, const DeviceTerms& terms)
    : arithmetic_(arithmetic),
      objective_(objective),
      basis_(arithmetic, objective.space(), basis),
      terms_(terms),
      shape_(objective.space().shape),
      scale_(shape_.voxel_mm / objective.space().thickness_mm),
      pull_(anchor_scale(objective.space(), scale_, terms.anchor.length_mm)),
      edge_(terms.regulariser.kind == RegulariserKind::huber_tv
                ? terms.regulariser.edge_slope * scale_
                : 0.0),
      diffusivity_(arithmetic.take(shape_.cells())) {
  check(terms.regulariser.kind != RegulariserKind::wang2008, "R is not one of a device");
}

void DeviceFunction::to_fields(const device::Buffer& z, const device::Buffer& fields) {
  basis_.to_fields(z, fields);
  const double mu = terms_.scale.mu();
  if (mu > 0.0) arithmetic_.each("log_of_scaled", shape_.cells(), std::log(mu), fields);
}

double DeviceFunction::value(const device::Buffer& fields) {
  const std::size_t cells = shape_.cells();
  const std::vector<double> range =
      arithmetic_.reduce("range_of", cells, 3, 1, static_cast<int>(cells), fields);
  const auto voxels = static_cast<double>(cells);
  const double data = objective_.value(fields, {range[0], {range[1] / voxels, range[2] / voxels}});
  if (!std::isfinite(data)) return data;
  set_roughness(fields);
  return data + terms_.weight * roughness_;
}

/// With the diffusivity of Huber-TV there.
void DeviceFunction::set_roughness(const device::Buffer& fields) {
  roughness_ = arithmetic_
                   .reduce("roughness", shape_.cells(), 1, 0, shape_.nx, shape_.ny, shape_.nz,
                           edge_, per_mu, scale_, pull_, terms_.anchor.log_kappa,
                           terms_.anchor.log_mu, fields, diffusivity_)
                   .front();
}

/// AbsorptionScale::by_scaled(), in place.
void DeviceFunction::by_scaled(const device::Buffer& fields, const device::Buffer& by_fields) {
  const double mu = terms_.scale.mu();
  if (mu > 0.0) arithmetic_.each("by_scaled", shape_.cells(), std::log(mu), fields, by_fields);
}

void DeviceFunction::adopt(DeviceFunction& before, const device::Buffer& fields,
                           const device::Buffer& step, const device::Buffer& change) {
  basis_.carry_gradient(before.basis_, change);
  const double added = terms_.weight - before.terms_.weight;
  if (added != 0.0) {
    set_roughness(fields);
    const device::Buffer moved = arithmetic_.take(size()), smoothing = arithmetic_.take(size());
    before.basis_.to_fields(step, moved);
    by_scaled(fields, moved);
    arithmetic_.launch("smoothing_product", {shape_.cells(), 1, 64, 1}, shape_.nx, shape_.ny,
                       shape_.nz, int{edge_ > 0.0}, per_mu, scale_, pull_, diffusivity_, moved,
                       smoothing);
    by_scaled(fields, smoothing);
    basis_.gradient(smoothing, moved);
    arithmetic_.each("add_scaled", size(), added, moved, change);
  }
  basis_.carry(before.basis_, step);
}

void DeviceFunction::gradient(const device::Buffer& fields, const device::Buffer& by_z) {
  const device::Buffer sum = arithmetic_.take(2 * shape_.cells());
  objective_.gradient(sum);
  const double mu = terms_.scale.mu();
  arithmetic_.launch("finish_gradient", {shape_.cells(), 1, 64, 1}, shape_.nx, shape_.ny, shape_.nz,
                     int{edge_ > 0.0}, per_mu, terms_.weight, scale_, pull_,
                     terms_.anchor.log_kappa, terms_.anchor.log_mu, int{mu > 0.0},
                     mu > 0.0 ? std::log(mu) : 0.0, fields, diffusivity_, sum);
  basis_.gradient(sum, by_z);
}

}  // namespace kappamu::inverse
