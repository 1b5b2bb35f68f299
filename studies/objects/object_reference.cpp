#include "studies/objects/object_reference.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/error.h"
#include "core/shown_text.h"
#include "forward/registry.h"
#include "io/atomic_file.h"
#include "studies/record.h"

namespace kappamu::studies {

namespace {

constexpr const char* format = "kappamu-object-reference";
/// Of recorded numbers that both sides compute: what another compiler may round otherwise.
constexpr double rounding = 1e-6;
/// Of the light that arrives: where shadows end its beams' places decide, which are no part of a
/// scene. A tenth of a reference's own error.
constexpr double places = 1e-3;

/// Four significant digits: errors are known to fewer.
Json numbers(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) {
    list.push_back(std::stod(shown_number(value, "%.4g")));
  }
  return list;
}

/// What a reference depends on.
Json description(const ObjectCase& object, const ObjectBench& bench, const Patches& patches) {
  double area = 0.0;
  for (const double a : patches.area) area += a;
  return {{"scene", object.name},
          {"kappa_mm", bench.kappa_mm},
          {"mu_per_mm", bench.mu_per_mm},
          {"eta", bench.object().boundary.eta},
          {"power_in_mm2", bench.power},
          {"area_mm2", area},
          {"triangles", bench.object().surface.size()},
          {"patches", patches.size()}};
}

}  // namespace

ObjectReference measure_reference(const ObjectBench& bench, const Patches& patches,
                                  std::uint64_t photons, std::uint64_t seed, Progress& progress) {
  forward::ObjectOptions options;
  options.seed = seed;
  const forward::ObjectResult result =
      forward::make_object_model("montecarlo", forward::ModelError::warned,
                                 {{"photons", static_cast<double>(photons)}})
          ->solve(bench.problem(), options, progress);
  const Surface& surface = bench.object().surface;
  return {patches.mean(result.exitance, surface),
          patches.error_of_mean(result.exitance, result.standard_error, surface), photons,
          result.seconds};
}

std::filesystem::path reference_file(const std::filesystem::path& folder,
                                     const ObjectCase& object) {
  return folder / (object.name + ".json");
}

void write_reference(const ObjectReference& reference, const ObjectCase& object,
                     const ObjectBench& bench, const Patches& patches,
                     const std::filesystem::path& file) {
  Json json{{"format", format}, {"version", 1}};
  json.update(description(object, bench, patches));
  json["photons"] = reference.photons;
  json["seconds"] = reference.seconds;
  json["exitance"] = numbers(reference.exitance);
  json["standard_error"] = numbers(reference.standard_error);
  io::write_text_atomically(file, json.dump() + "\n");
}

ObjectReference read_reference(const ObjectCase& object, const ObjectBench& bench,
                               const Patches& patches, const std::filesystem::path& file) {
  ObjectReference reference;
  try {
    std::ifstream in(file);
    const Json json = Json::parse(in);
    if (json.at("format") != format || json.at("version") != 1) {
      throw InputError(file.string() + ": is no reference of an object; remove it");
    }
    const Json expected = description(object, bench, patches);
    for (const auto& [name, value] : expected.items()) {
      const Json& recorded = json.at(name);
      const double allowed = name == "power_in_mm2" ? places : rounding;
      const bool same = value.is_number_float()
                            ? std::abs(recorded.get<double>() - value.get<double>()) <=
                                  allowed * std::abs(value.get<double>())
                            : recorded == value;
      if (!same) {
        throw InputError(file.string() + ": " + name + " is " + recorded.dump() +
                         " where the scene has " + value.dump() +
                         "; remove the file and measure the reference anew");
      }
    }
    reference.exitance = json.at("exitance").get<std::vector<double>>();
    reference.standard_error = json.at("standard_error").get<std::vector<double>>();
    reference.photons = json.at("photons");
    reference.seconds = json.at("seconds");
  } catch (const Json::exception& error) {
    throw InputError(file.string() + ": is damaged (" + error.what() +
                     "); remove it and measure the reference anew");
  }
  if (reference.exitance.size() != patches.size() ||
      reference.standard_error.size() != patches.size()) {
    throw InputError(file.string() + ": holds another number of patches than it states; remove it");
  }
  return reference;
}

ObjectError error_against(const ObjectReference& reference, const Patches& patches,
                          const std::vector<double>& exitance, double allowed) {
  double difference = 0.0, noise = 0.0, signal = 0.0;
  double mean = 0.0, mean_noise = 0.0, total = 0.0, outside = 0.0, area = 0.0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const double a = patches.area[p], r = reference.exitance[p], s = reference.standard_error[p];
    const double d = std::abs(exitance[p] - r);
    difference += a * d * d;
    noise += a * s * s;
    signal += a * r * r;
    mean += a * d;
    mean_noise += a * s * std::sqrt(2.0 / std::numbers::pi);  // E|x| of a normal deviate
    total += a * r;
    if (d > 3.0 * s + allowed * r) outside += a;
    area += a;
  }
  const double true_signal = std::max(signal - noise, noise);
  return {std::sqrt(std::max(0.0, difference - noise) / true_signal),
          std::sqrt(noise / true_signal), mean / total, mean_noise / total, outside / area};
}

}  // namespace kappamu::studies
