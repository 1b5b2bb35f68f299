#include "forward/dipole/relight.h"

#include <algorithm>

#include "core/error.h"
#include "forward/dipole/hierarchy/hierarchy.h"
#include "forward/dipole/sum_check.h"
#include "forward/dipole/transmitted.h"

namespace kappamu::forward::dipole {

namespace {

std::vector<Profile> profiles_of(const std::array<const ObjectMedium*, 3>& media, double eta) {
  std::vector<Profile> profiles;
  for (const ObjectMedium* medium : media) {
    if (!medium->homogeneous()) {
      throw InputError("the dipole answers for a homogeneous medium alone; use the model embedded");
    }
    const Coefficients c = medium->smallest();
    profiles.push_back(make_profile("dipole", {c.kappa, c.mu}, eta));
  }
  return profiles;
}

}  // namespace

struct Relight::State {
  const Surface& surface;
  double eta;
  std::vector<Profile> profiles;
  SumCheck check;
  Hierarchy hierarchy;
};

Relight::Relight(const TriangleMesh& mesh, const Surface& surface,
                 const std::array<const ObjectMedium*, 3>& media, double eta,
                 const ObjectOptions& options) {
  std::vector<Profile> profiles = profiles_of(media, eta);
  Hierarchy hierarchy(
      device::Context::of(device::choose(device::list_devices(), options.device).index), mesh,
      profiles);
  state_ = std::make_unique<State>(State{surface, eta, std::move(profiles),
                                         SumCheck(mesh, surface, surface.area, options.seed),
                                         std::move(hierarchy)});
}

Relight::~Relight() = default;

std::array<std::vector<double>, 3> Relight::exitance(const std::array<ObjectLight, 3>& light) {
  const std::size_t samples = state_->surface.size();
  std::vector<Eigen::Array4f> in(samples, Eigen::Array4f::Zero());
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<double> entering = transmitted(state_->surface, state_->eta, light[c]);
    for (std::size_t t = 0; t < samples; ++t) {
      in[t][static_cast<Eigen::Index>(c)] = static_cast<float>(entering[t]);
    }
  }
  const std::vector<Eigen::Array4f> out = state_->hierarchy.exitance(in);
  std::array<std::vector<double>, 3> result;
  for (std::size_t c = 0; c < 3; ++c) {
    result[c].reserve(samples);
    for (const Eigen::Array4f& value : out) {
      result[c].push_back(static_cast<double>(value[static_cast<Eigen::Index>(c)]));
    }
  }
  return result;
}

double Relight::measured_error(const std::array<ObjectLight, 3>& light,
                               const std::array<std::vector<double>, 3>& exitance) const {
  double worst = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<double> exact =
        state_->check.exact(state_->profiles[c], Placement::rotated,
                            transmitted(state_->surface, state_->eta, light[c]));
    worst = std::max(worst, state_->check.error(exact, exitance[c]));
  }
  return worst;
}

}  // namespace kappamu::forward::dipole
