#include "io/volume/volume_set.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/file_name.h"

namespace kappamu::io {

namespace {

[[noreturn]] void fail(const std::string& source, const std::string& why) {
  throw InputError(source + ": " + why);
}

void validate_extra(const VolumeSet& set, const std::vector<Volume<double>>& volumes,
                    const std::string& name, const std::string& source) {
  if (volumes.empty()) return;
  if (volumes.size() != set.channels.size()) fail(source, name + " is not given for each channel");
  for (const auto& volume : volumes) {
    if (!(volume.shape() == set.shape())) fail(source, name + " has another shape than kappa");
    const bool good = std::all_of(volume.values().begin(), volume.values().end(),
                                  [](double v) { return std::isfinite(v) && v >= 0.0; });
    if (!good) fail(source, name + " has a negative or non-finite value");
  }
}

}  // namespace

void validate(const VolumeSet& set, const std::string& source) {
  if (set.channels.empty() || set.media.size() != set.channels.size()) {
    fail(source, "must have kappa and mu for at least one channel");
  }
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    const std::string& name = set.channels[c];
    require_plain_name(name, source + ": a channel's name");
    if (std::count(set.channels.begin(), set.channels.end(), name) > 1) {
      fail(source, "channel '" + name + "' is there twice");
    }
    const Medium& medium = set.media[c];
    if (!(medium.kappa.shape() == set.shape()) || !(medium.mu.shape() == set.shape())) {
      fail(source, "kappa and mu of channel " + name + " do not have one shape");
    }
    if (medium.kappa.size() == 0) fail(source, "volumes are empty");
    kappamu::validate(medium, std::string(source).append(", channel ").append(name));
  }
  validate_extra(set, set.kappa_std, "standard deviation of kappa", source);
  validate_extra(set, set.mu_std, "standard deviation of mu", source);
  validate_extra(set, set.kappa_resolution, "resolution of kappa", source);
  validate_extra(set, set.mu_resolution, "resolution of mu", source);
  validate_extra(set, set.sensitivity, "sensitivity", source);
  if (set.eta && !(*set.eta >= 1.0 && *set.eta <= 4.0)) {
    fail(source, "eta must lie between 1 and 4");
  }
}

std::vector<NamedVolume> named_volumes(const VolumeSet& set) {
  std::vector<NamedVolume> result;
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    result.push_back({"kappa_" + set.channels[c], "mm", &set.media[c].kappa});
    result.push_back({"mu_" + set.channels[c], "1/mm", &set.media[c].mu});
  }
  const auto add = [&](const std::vector<Volume<double>>& volumes, const std::string& prefix,
                       const std::string& unit) {
    for (std::size_t c = 0; c < volumes.size(); ++c) {
      result.push_back({prefix + set.channels[c], unit, &volumes[c]});
    }
  };
  add(set.kappa_std, "std_kappa_", "mm");
  add(set.mu_std, "std_mu_", "1/mm");
  add(set.kappa_resolution, "resolution_kappa_", "1");
  add(set.mu_resolution, "resolution_mu_", "1");
  add(set.sensitivity, "sensitivity_", "1");
  return result;
}

ScatteringVolumes scattering_volumes(const Medium& medium) {
  const GridShape& shape = medium.kappa.shape();
  ScatteringVolumes result{Volume<double>(shape), Volume<double>(shape), 0};
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    const double albedo = 1.0 - 3.0 * medium.kappa[i] * medium.mu[i];
    result.sigma_t[i] = 1.0 / (3.0 * medium.kappa[i]);
    result.albedo[i] = std::max(albedo, 0.0);
    if (albedo <= 0.0) ++result.clamped;
  }
  return result;
}

}  // namespace kappamu::io
