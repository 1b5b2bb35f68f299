#include "studies/objects/object_bench.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/processor_time.h"
#include "forward/choice/pilot.h"
#include "studies/objects/object_measurement.h"

namespace kappamu::studies {

namespace {

/// A model that is expected to take so many times longer than the one taken, or so many seconds, is
/// not measured.
constexpr double hopeless_cost = 4.0, hopeless_seconds = 20.0;

/// Random walks beyond these are not made: their seconds grow with the photons, and their noise
/// follows from the reference's.
constexpr std::uint64_t walked_photons = 50'000;

struct Tried {
  std::string model;
  double error = 0.0, seconds = 0.0;  ///< of processor
};

/// Every model that answers by itself; of what takes much longer than `seconds`, random walks
/// alone.
std::vector<Tried> try_all(const ObjectMeasurement& measurement,
                           const forward::ChoiceOptions& asked, double seconds) {
  std::vector<Tried> tried;
  const std::span features(&measurement.features(), 1);
  for (const forward::ModelCandidate& candidate :
       forward::choose_model(forward::choosable_models(), features, asked, forward::Remedy::none)
           .candidates) {
    const forward::ModelDescription& model = forward::object_model(candidate.model);
    const bool random = model.can.transport;
    const double expected = candidate.seconds.value_or(0.0);
    if (!candidate.error || expected > hopeless_cost * seconds) continue;
    if (!random && expected > hopeless_seconds) continue;
    forward::ChoiceOptions options = forward::options_for(model, features, asked);
    const auto photons = options.photons;
    if (random) options.photons = std::min(photons, walked_photons);
    const Json row = measurement.row(candidate.model, options, options.photons);
    if (row.contains("refused")) continue;
    tried.push_back({candidate.model, row.at("error"), row.at("cpu_seconds")});
    if (!random) continue;
    tried.back().error = measurement.noise_of_patches(photons);
    tried.back().seconds *= static_cast<double>(photons) / static_cast<double>(options.photons);
  }
  return tried;
}

Json row_of(const ObjectCase& object, const ObjectMeasurement& measurement, double tolerance,
            Progress& progress) {
  forward::ChoiceOptions asked{measurement.options(), 1ULL << 31};
  asked.tolerance = tolerance;
  const std::span features(&measurement.features(), 1);
  const forward::ObjectProblem problem = measurement.problem();
  forward::Choice choice;
  std::optional<forward::Pilot> pilot;
  double pilot_seconds = std::numeric_limits<double>::infinity();
  for (int run = 0; run < 2; ++run) {
    const double before = processor_seconds();
    choice =
        forward::choose_model(forward::choosable_models(), features, asked, forward::Remedy::walks);
    pilot = forward::run_pilot(std::span(&problem, 1), features, asked, choice, progress);
    pilot_seconds = pilot ? std::min(pilot_seconds, processor_seconds() - before) : 0.0;
    if (!pilot || pilot_seconds > brief_seconds) break;
  }
  const bool corrected = pilot && pilot->within;
  const forward::ModelCandidate& first = choice.candidates.front();
  const std::vector<Tried> tried =
      try_all(measurement, asked, corrected ? pilot_seconds : first.seconds.value());
  Tried taken{first.model, 0.0, pilot_seconds};
  if (corrected) taken.error = measurement.error_of(pilot->results.front());
  std::optional<Tried> cheapest;
  Json measured = Json::object();
  for (const forward::ModelDescription& model : forward::object_models()) {
    if (model.measured == nullptr) continue;
    measured[model.name + "_error"] = nullptr;
    measured[model.name + "_cpu_seconds"] = nullptr;
  }
  for (const Tried& one : tried) {
    measured[one.model + "_error"] = one.error;
    measured[one.model + "_cpu_seconds"] = one.seconds;
    if (one.error <= tolerance && (!cheapest || one.seconds < cheapest->seconds)) cheapest = one;
    if (corrected || one.model != taken.model) continue;
    taken.error = one.error;
    taken.seconds += one.seconds;
  }
  Json row{{"name", object.name},
           {"tolerance", tolerance},
           {"model", taken.model},
           {"corrected", corrected},
           {"expected_error", first.error.value_or(0.0)},
           {"within_tolerance", choice.within_tolerance},
           {"error", taken.error},
           {"met", taken.error <= tolerance},
           {"cpu_seconds", taken.seconds}};
  row["pilot"] = pilot ? Json(pilot->model) : Json();
  row["pilot_photons"] = pilot ? Json(pilot->photons) : Json();
  row["cheapest"] = cheapest ? Json(cheapest->model) : Json();
  row["cost_ratio"] = cheapest ? Json(taken.seconds / cheapest->seconds) : Json();
  row.update(measured);
  return row;
}

}  // namespace

void measure_auto(const Request& request, Progress& progress, const Save& save) {
  const ObjectSettings settings = object_settings(request);
  std::vector<std::string> wanted = request.words("scenes");
  const bool quick = request.size == Size::quick;
  if (wanted.empty() && quick) wanted = {"brick-potato-16-side"};
  const std::vector<double> tolerances = quick ? std::vector{0.2} : std::vector{0.03, 0.06, 0.12};
  Json rows = Json::array();
  const int drawn = request.count("draw", 0);
  const std::vector<ObjectCase> cases = drawn > 0 ? drawn_cases(drawn, request.seed, wanted)
                                                  : object_cases(Population::validation, wanted);
  for (const ObjectCase& object : cases) {
    const ObjectMeasurement measurement(object, settings, request, progress);
    for (const double tolerance : tolerances) {
      rows.push_back(row_of(object, measurement, tolerance, progress));
      save({{"rows", rows}});
    }
  }
}

}  // namespace kappamu::studies
