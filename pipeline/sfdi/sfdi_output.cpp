#include "pipeline/sfdi/sfdi_output.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/shown_text.h"
#include "io/image/exr.h"
#include "io/npy.h"
#include "pipeline/sfdi/sfdi_spectra.h"

namespace kappamu::pipeline::sfdi {

namespace {

using Json = nlohmann::ordered_json;
using MapMember = Image<float> WavelengthMap::*;

const std::vector<std::pair<std::string, MapMember>>& members() {
  static const std::vector<std::pair<std::string, MapMember>> all{
      {"mua", &WavelengthMap::mua},
      {"musp", &WavelengthMap::musp},
      {"kappa", &WavelengthMap::kappa},
      {"mua_deviation", &WavelengthMap::mua_deviation},
      {"musp_deviation", &WavelengthMap::musp_deviation},
      {"kappa_deviation", &WavelengthMap::kappa_deviation}};
  return all;
}

/// Of the valid pixels: the values below which a tenth, half and nine tenths lie.
Json quantiles(const Image<float>& map) {
  std::vector<float> values;
  for (const float value : map.values()) {
    if (std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto at = [&](double part) {
    return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
  };
  return {{"tenth", at(0.1)}, {"median", at(0.5)}, {"nine_tenths", at(0.9)}};
}

Json wavelength_json(const WavelengthMap& map) {
  Json json;
  if (map.name.empty()) {
    json["wavelength_nm"] = map.wavelength_nm;
  } else {
    json["channel"] = map.name;
  }
  for (const auto& [name, member] : members()) json[name] = quantiles(map.*member);
  std::array<std::size_t, inverse::lateral_verdict_names.size()> counts{};
  for (const std::uint8_t verdict : map.verdict.values()) ++counts[verdict];
  for (const auto& [name, verdict] : inverse::lateral_verdict_names) {
    json["pixels"][name] = counts[static_cast<std::size_t>(verdict)];
  }
  for (const auto& [name, part] : part_names) {
    const auto& parts = map.parts[static_cast<std::size_t>(part)];
    json["relative_deviation"][name] = {{"mua", parts[0]}, {"musp", parts[1]}};
  }
  if (!map.height_mm.empty()) json["height_mm"] = quantiles(map.height_mm);
  for (const LightCheck& check : map.checks) {
    Json one{{"per_mm", check.per_mm}};
    if (check.found_per_mm) one["found_per_mm"] = *check.found_per_mm;
    one["second_harmonic"] = check.second_harmonic;
    one["stripes"] = check.stripes;
    one["saturated"] = check.saturated;
    if (check.shift_mm) one["shift_mm"] = *check.shift_mm;
    json["pictures"].push_back(one);
  }
  if (map.region) {
    const RegionMean& region = *map.region;
    json["region"] = {{"pixels", region.pixels},
                      {"mua", region.mean.mua},
                      {"mua_deviation", region.deviation[0]},
                      {"mua_spread", region.spread[0]},
                      {"musp", region.mean.musp},
                      {"musp_deviation", region.deviation[1]},
                      {"musp_spread", region.spread[1]}};
  }
  if (map.layers) {
    const TwoLayers& layers = *map.layers;
    for (const std::size_t lower : {0U, 1U}) {
      const inverse::LateralCoefficients& of = lower == 0 ? layers.upper : layers.lower;
      const auto& deviation = layers.relative_deviation;
      json["layers"][lower == 0 ? "upper" : "lower"] = {
          {"mua", of.mua},
          {"mua_relative_deviation", deviation[2 * lower]},
          {"mua_determined", static_cast<bool>(layers.determined[2 * lower])},
          {"musp", of.musp},
          {"musp_relative_deviation", deviation[2 * lower + 1]},
          {"musp_determined", static_cast<bool>(layers.determined[2 * lower + 1])}};
    }
    json["layers"]["chi_square"] = layers.chi_square;
    json["layers"]["converged"] = layers.converged;
  }
  return json;
}

}  // namespace

std::vector<std::string> map_files(const Description& description) {
  std::vector<std::string> files{"maps.exr", "verdict.npy", "summary.json"};
  for (const auto& [name, member] : members()) files.push_back(name + ".npy");
  if (description.projector) files.push_back("height.npy");
  for (const std::string& name : spectral_names(description)) {
    files.push_back(name + ".npy");
    files.push_back(name + "_deviation.npy");
  }
  return files;
}

void write_maps(const Maps& maps, const std::filesystem::path& folder) {
  const WavelengthMap& first_map = maps.wavelengths.front();
  const Image<float>& first = first_map.mua;
  const std::vector<std::size_t> shape{maps.wavelengths.size(),
                                       static_cast<std::size_t>(first.height()),
                                       static_cast<std::size_t>(first.width())};
  io::ExrImage exr{first.width(), first.height(), {}, {}};
  exr.attributes["units"] =
      "mua, musp [1/mm], kappa [mm], deviations standard; verdict 0 where valid";
  for (const auto& [name, member] : members()) {
    std::vector<float> all;
    for (const WavelengthMap& map : maps.wavelengths) {
      const std::vector<float>& values = (map.*member).values();
      all.insert(all.end(), values.begin(), values.end());
      exr.channels[map.key() + "." + name] = values;
    }
    io::write_npy(folder / (name + ".npy"), shape, std::span<const float>(all));
  }
  std::vector<std::uint8_t> verdicts;
  for (const WavelengthMap& map : maps.wavelengths) {
    const std::vector<std::uint8_t>& values = map.verdict.values();
    verdicts.insert(verdicts.end(), values.begin(), values.end());
    exr.channels[map.key() + ".verdict"].assign(values.begin(), values.end());
  }
  if (!first_map.height_mm.empty()) {
    std::vector<float> all;
    for (const WavelengthMap& map : maps.wavelengths) {
      const std::vector<float>& values = map.height_mm.values();
      all.insert(all.end(), values.begin(), values.end());
      exr.channels[map.key() + ".height"] = values;
    }
    io::write_npy(folder / "height.npy", shape, std::span<const float>(all));
  }
  for (const SpectralMap& map : maps.spectral) {
    for (const auto& [name, image] :
         {std::pair{map.name, &map.value}, std::pair{map.name + "_deviation", &map.deviation}}) {
      exr.channels["spectral." + name] = image->values();
      io::write_npy(folder / (name + ".npy"), {shape[1], shape[2]},
                    std::span<const float>(image->values()));
    }
  }
  io::write_npy(folder / "verdict.npy", shape, std::span<const std::uint8_t>(verdicts));
  io::write_exr(folder / "maps.exr", exr);
}

Json summary_of(const Maps& maps, const Description& description, double seconds) {
  Json json{{"format", "kappamu-map"},
            {"version", 1},
            {"pixel_mm", description.pixel_mm},
            {"refractive_index", description.medium.refractive_index},
            {"anisotropy", description.medium.anisotropy}};
  if (description.medium.thickness_mm) json["thickness_mm"] = *description.medium.thickness_mm;
  json["scale"] = description.reference ? "phantom" : "absolute";
  for (const WavelengthMap& map : maps.wavelengths) {
    json["wavelengths"].push_back(wavelength_json(map));
  }
  for (const SpectralMap& map : maps.spectral) {
    json["spectral"][map.name] = {{"unit", map.unit},
                                  {"value", quantiles(map.value)},
                                  {"deviation", quantiles(map.deviation)}};
  }
  if (maps.chi_square) json["chi_square_per_degree_of_freedom"] = *maps.chi_square;
  json["warnings"] = maps.warnings;
  json["seconds"] = seconds;
  return json;
}

}  // namespace kappamu::pipeline::sfdi
