// What a fit says about itself: fit/fit.json and the volumes beside it.
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/file_name.h"
#include "io/json_reason.h"
#include "io/json_whole.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "io/volume/npy_volume.h"
#include "io/volume/volume_file.h"
#include "report/read/run_data.h"

namespace kappamu::report {

namespace {

using nlohmann::json;

/// Runs `interpret` on the parsed file; what is missing or of the wrong kind becomes one sentence.
template <class Result>
Result interpret_json(const std::filesystem::path& file, Result (*interpret)(const json&)) {
  try {
    return interpret(json::parse(io::read_text(file)));
  } catch (const json::exception& error) {
    throw InputError(file.string() + ": not as kappamu writes it (" + io::json_reason(error) +
                         "); repeat that stage",
                     {{"force"}});
  }
}

std::vector<std::string> warnings_of(const json& object) {
  return object.value("warnings", std::vector<std::string>{});
}

Convergence convergence_from_json(const json& object) {
  Convergence convergence;
  convergence.channel = object.at("name").get<std::string>();
  convergence.status = object.at("status").get<std::string>();
  convergence.reason = object.value("reason", std::string());
  if (object.contains("model")) {
    const json& model = object["model"];
    convergence.model = model.at("name").get<std::string>();
    convergence.model_reason = model.at("reason").get<std::string>();
  }
  convergence.notes = object.value("notes", std::vector<std::string>{});
  convergence.chi2_per_value = object.at("chi2_per_value").get<double>();
  if (object.contains("seconds")) convergence.seconds = object["seconds"].get<double>();
  for (const json& step : object.value("history", json::array())) {
    convergence.adjoint_solves.push_back(step.at("adjoint_solves").get<double>());
    convergence.objective.push_back(step.at("objective").get<double>());
    convergence.chi2.push_back(step.at("chi2_per_value").get<double>());
  }
  return convergence;
}

/// The sentence of each channel that has one.
std::vector<std::optional<std::string>> sentences_from_json(const json& object) {
  std::vector<std::optional<std::string>> sentences;
  for (const json& channel : object.at("channels")) {
    sentences.emplace_back();
    if (!channel.contains("uncertainty")) continue;
    sentences.back() = channel["uncertainty"].at("sentence").get<std::string>();
  }
  return sentences;
}

FitData fit_from_json(const json& object) {
  FitData data;
  data.verdict = pipeline::verdict_from_json(object.at("verdict"));
  for (const json& channel : object.at("channels")) {
    data.convergence.push_back(convergence_from_json(channel));
    data.channels.push_back(data.convergence.back().channel);
    require_plain_name(data.channels.back(), "fit/fit.json: a channel's name");
  }
  data.warnings = warnings_of(object);
  data.lit_pixels = object.value("lit_pixels", false);
  const json validation = object.value("validation", json::object());
  data.validation = io::whole_numbers<int>(validation.value("patterns", json::array()));
  return data;
}

double voxel_from_json(const json& object) {
  return object.at("voxel_mm").get<double>();
}

/// Files hold deviations of κ and μ: those of their logarithms are relative to them.
Volume<double> relative(Volume<double> deviation, const Volume<double>& value) {
  for (std::size_t i = 0; i < deviation.size(); ++i) {
    deviation[i] = value[i] > 0.0 ? deviation[i] / value[i] : 0.0;
  }
  return deviation;
}

/// Of a volume [z][y][x] that is not read as a whole.
Image<float> middle_layer(const std::filesystem::path& file) {
  const std::vector<std::size_t> shape = io::read_npy_layout(file).shape;
  if (shape.size() != 3 || shape[0] * shape[1] * shape[2] == 0) {
    throw InputError(file.string() + ": array has shape " + io::shape_to_string(shape) +
                     "; a volume is [z][y][x]");
  }
  Image<float> layer(static_cast<int>(shape[2]), static_cast<int>(shape[1]), 1);
  layer.values() =
      io::read_npy_part(file, shape[0] / 2 * layer.values().size(), layer.values().size());
  return layer;
}

}  // namespace

std::optional<FitData> read_fit(const std::filesystem::path& run) {
  const std::filesystem::path folder = run / "fit";
  const std::filesystem::path file = folder / "fit.json";
  if (!std::filesystem::exists(file)) return std::nullopt;
  FitData data = interpret_json(file, fit_from_json);
  const double voxel_mm = interpret_json(file, voxel_from_json);
  // What is too large for one machine has a coarser volume beside.
  const std::filesystem::path coarse = folder / "coarse";
  if (std::filesystem::exists(coarse / "volume.json")) {
    io::VolumeSet shown = io::read_volume_folder(coarse);
    data.means_of = static_cast<int>(std::lround(shown.shape().voxel_mm / voxel_mm));
    data.media = std::move(shown.media);
    for (const std::string& channel : data.channels) {
      data.middle_layers.push_back({middle_layer(folder / ("kappa_" + channel + ".npy")),
                                    middle_layer(folder / ("mu_" + channel + ".npy"))});
    }
    const std::size_t layers =
        io::read_npy_layout(folder / ("kappa_" + data.channels.front() + ".npy")).shape.front();
    data.middle_mm = (static_cast<double>(layers / 2) + 0.5) * voxel_mm;
  } else {
    for (const std::string& channel : data.channels)
      data.media.push_back({io::read_npy_volume(folder / ("kappa_" + channel + ".npy"), voxel_mm),
                            io::read_npy_volume(folder / ("mu_" + channel + ".npy"), voxel_mm)});
  }
  const auto sentences = interpret_json(file, sentences_from_json);
  for (std::size_t c = 0; c < sentences.size(); ++c) {
    const auto volume = [&](const std::string& name) {
      return io::read_npy_volume(folder / (name + "_" + data.channels[c] + ".npy"), voxel_mm);
    };
    data.uncertainty.emplace_back();
    if (!sentences[c]) continue;
    const Medium& medium = data.media[c];
    data.uncertainty.back() = {
        *sentences[c],
        {relative(volume("std_kappa"), medium.kappa), relative(volume("std_mu"), medium.mu)},
        {volume("resolution_kappa"), volume("resolution_mu")}};
  }
  return data;
}

}  // namespace kappamu::report
