#include "pipeline/stages/fit_output.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>
#include <vector>

#include "io/npy.h"
#include "io/volume/npy_volume.h"

namespace kappamu::pipeline {

namespace {

Volume<double> scaled(const Volume<float>& deviation, const Volume<double>& value) {
  Volume<double> result(value.shape());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = value[i] * deviation[i];
  return result;
}

Volume<double> as_double(const Volume<float>& volume) {
  return {volume.shape(), {volume.values().begin(), volume.values().end()}};
}

}  // namespace

void write_maps(const std::filesystem::path& file, const SurfaceMeasurements& measurements,
                std::size_t channels, const std::vector<float>& values) {
  const FaceShape face = measurements.seen_shape();
  io::write_npy(file,
                {channels, static_cast<std::size_t>(measurements.patterns),
                 static_cast<std::size_t>(face.nv), static_cast<std::size_t>(face.nu)},
                std::span<const float>(values));
}

void put_patterns(std::vector<float>& all, std::size_t cells, const std::vector<int>& patterns,
                  const std::vector<float>& part) {
  for (std::size_t k = 0; k < patterns.size(); ++k) {
    std::copy_n(
        part.begin() + static_cast<std::ptrdiff_t>(k * cells), cells,
        all.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(patterns[k]) * cells));
  }
}

void write_sensitivity(const std::filesystem::path& folder, const std::string& channel,
                       const inverse::ChannelFit& fit, io::VolumeSet& volumes) {
  Volume<double> joint(fit.medium.kappa.shape());
  for (std::size_t i = 0; i < joint.size(); ++i) {
    joint[i] = std::hypot(fit.sensitivity_kappa[i], fit.sensitivity_mu[i]);
  }
  io::write_npy_volume(folder / ("sensitivity_" + channel + ".npy"), joint);
  volumes.sensitivity.push_back(std::move(joint));
}

void write_uncertainty(const std::filesystem::path& folder, const std::string& channel,
                       const inverse::Uncertainty& uncertainty, const Medium& medium,
                       io::VolumeSet& volumes) {
  const auto keep = [&](const std::string& name, Volume<double> volume,
                        std::vector<Volume<double>>& kept) {
    io::write_npy_volume(folder / (name + "_" + channel + ".npy"), volume);
    kept.push_back(std::move(volume));
  };
  keep("std_kappa", scaled(uncertainty.log_kappa_std, medium.kappa), volumes.kappa_std);
  keep("std_mu", scaled(uncertainty.log_mu_std, medium.mu), volumes.mu_std);
  keep("resolution_kappa", as_double(uncertainty.kappa_resolution), volumes.kappa_resolution);
  keep("resolution_mu", as_double(uncertainty.mu_resolution), volumes.mu_resolution);
  io::write_npy_volume(folder / ("correlation_" + channel + ".npy"),
                       as_double(uncertainty.correlation));
}

nlohmann::ordered_json uncertainty_json(const inverse::UncertaintyReport& report) {
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  for (const inverse::LayerUncertainty& layer : report.layers) {
    layers.push_back({{"depth_mm", layer.depth_mm},
                      {"log_kappa_std", layer.log_kappa_std},
                      {"log_mu_std", layer.log_mu_std},
                      {"kappa_fwhm_mm", layer.kappa_fwhm_mm},
                      {"mu_fwhm_mm", layer.mu_fwhm_mm},
                      {"kappa_resolution", layer.kappa_resolution},
                      {"mu_resolution", layer.mu_resolution},
                      {"correlation", layer.correlation}});
  }
  nlohmann::ordered_json json{{"sentence", report.sentence},
                              {"batched_solves", report.solves},
                              {"seconds", report.seconds},
                              {"layers", layers}};
  if (report.shared) {
    json["shared_log_kappa_std"] = report.shared->log_kappa;
    json["shared_log_mu_std"] = report.shared->log_mu;
  }
  return json;
}

}  // namespace kappamu::pipeline
