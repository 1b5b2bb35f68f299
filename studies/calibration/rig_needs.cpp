#include "studies/calibration/rig_needs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "core/error.h"
#include "core/numbers/median.h"
#include "data_synthetic/rig/rig.h"
#include "data_synthetic/score.h"
#include "studies/calibration/rig_trial.h"
#include "studies/inverse/dense_fit.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

constexpr int all_exposures = 9;
constexpr int usual_exposures = 5;
constexpr int channel = 1;                   // G
constexpr double median_of_normal = 0.6745;  // of |x| of deviation 1
constexpr const char* predicted_end = "_predicted";

/// With as few rendered boards as do: their corners are exact to 0.002 px.
synthetic::SimulationOptions tiny(std::uint64_t seed) {
  synthetic::SimulationOptions options;
  options.sample = "tiny";
  options.seed = seed;
  options.light = {capture::LightShape::patches, 3};
  options.validation = false;
  options.holdout = 4;
  options.board_views = 9;
  options.projector_planes = 4;
  options.exposures_s =
      synthetic::SimulationOptions::geometric_exposures(1.0 / 30.0, 8.0, all_exposures);
  return options;
}

/// Of |x| over κ or μ of all voxels.
struct Changes {
  double kappa = 0.0;
  double mu = 0.0;
};
Changes of_median_voxel(const Eigen::VectorXd& change) {
  const auto median_of = [](const auto& values) {
    return upper_median(std::vector<double>(values.begin(), values.end()));
  };
  const Eigen::VectorXd size = change.cwiseAbs();
  const Eigen::Index cells = size.size() / 2;
  return {median_of(size.head(cells)), median_of(size.tail(cells))};
}

/// One case over the rigs: what is measured of it, by the names of the record, to become medians.
class Case {
 public:
  Case(const char* part, const RigViews& views, int exposures)
      : row_{{"part", part},
             {"boards", views.boards},
             {"planes", views.planes},
             {"exposures", exposures},
             {"refused", 0}} {}
  void add(const std::string& name, double value) { values_[name].push_back(value); }
  void add(const Changes& found, const std::string& end = "") {
    add("log_kappa" + end, found.kappa);
    add("log_mu" + end, found.mu);
  }
  void add(const synthetic::CalibrationErrors& errors) {
    add("camera_px", errors.camera_face_px);
    add("projector_px", errors.projector_face_px);
    add("turn_degrees", errors.camera_angle_degrees);
    add("scale_relative", errors.scale_relative);
  }
  void refuse() { row_["refused"] = row_["refused"].get<int>() + 1; }
  Json row() const {
    Json row = row_;
    for (const auto& [name, values] : values_) row[name] = median(values);
    return row;
  }

 private:
  Json row_;
  std::map<std::string, std::vector<double>> values_;
};

double relative_change(const SurfaceMeasurements& found, const SurfaceMeasurements& expected) {
  std::vector<double> changes;
  for (std::size_t i = 0; i < found.value.size(); ++i) {
    if (found.mask[i] == 0 || expected.mask[i] == 0) continue;
    changes.push_back(std::abs(found.value[i] / expected.value[i] - 1.0));
  }
  return upper_median(std::move(changes));
}

/// One rig: its session, and a fit to the best measurements it can give.
class Rig {
 public:
  Rig(const RigNeedsOptions& options, std::uint64_t seed, Progress& progress)
      : options_(options),
        seed_(seed),
        progress_(progress),
        random_(seed),
        shot_(tiny(seed), options.folder / ("rig" + std::to_string(seed)), options.device,
              progress),
        usual_(shot_.with_exposures(usual_exposures)),
        best_(usual_.measured(usual_.calibrated(true_lenses(usual_.truth())))),
        fit_(best_, channel, fit_options(options.device)) {}

  void best(Case& result) {
    const synthetic::Truth& truth = usual_.truth();
    result.add(synthetic::calibration_errors(usual_.calibrated(true_lenses(truth)), truth));
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(fit_.unknowns());
    result.add("validation_E", validation_error(none));
    const Medium expected =
        synthetic::true_medium(truth, usual_.truth_folder(), truth.channels[channel]);
    result.add(of_median_voxel(fit_.fitted() - joined(inverse::to_fields(expected))));
  }

  /// Throws InputError where the calibration does.
  void views(const RigViews& views, Case& result) {
    synthetic::SimulationOptions options = tiny(seed_);
    options.board_views = 60;  // to choose from: the first few would lie in one row of the picture
    options.projector_planes = views.planes;
    synthetic::Rig rig = synthetic::make_rig(options);
    std::shuffle(rig.camera_from_board.begin(), rig.camera_from_board.end(), random_);
    rig.camera_from_board.resize(static_cast<std::size_t>(views.boards));
    const calib::JointCalibration joint = calibrate_corners(rig, options_.corner_noise_px, random_);
    const calib::CalibrationResult calibration = usual_.calibrated(
        {joint.camera.lens, joint.projector.lens, joint.projector.projector_from_station});
    const SurfaceMeasurements found = usual_.measured(calibration);
    result.add(synthetic::calibration_errors(calibration, usual_.truth()));
    result.add("value_relative", relative_change(found, best_));
    const Eigen::VectorXd change = fit_.refitted(found);
    result.add(of_median_voxel(change));
    result.add("validation_E", validation_error(change));
    const Eigen::VectorXd linear = fit_.change(found);
    std::vector<double> kappa;
    std::vector<double> mu;
    for (int draw = 0; draw < options_.draws; ++draw) {
      const SurfaceMeasurements other = usual_.measured(usual_.calibrated(drawn(joint, random_)));
      const Changes predicted = of_median_voxel(fit_.change(other) - linear);
      kappa.push_back(predicted.kappa);
      mu.push_back(predicted.mu);
    }
    result.add({median(kappa), median(mu)}, predicted_end);
  }

  void exposures(int count, Case& result) {
    const RigTrial own = shot_.with_exposures(count);
    const calib::CalibrationResult& calibration = own.calibration();
    const SurfaceMeasurements found = own.measured(calibration);
    const SurfaceMeasurements exact = own.exact(calibration);
    result.add(synthetic::calibration_errors(calibration, own.truth()));
    result.add("value_relative", relative_change(found, exact));
    const Eigen::VectorXd change = fit_.refitted(found);
    result.add(of_median_voxel(change - fit_.refitted(exact)));
    result.add("validation_E", validation_error(change));
    const Variances noise = fit_.propagated(own.measured(calibration, {0.0, 0.0}));
    result.add(of_median_voxel(median_of_normal * noise.cwiseSqrt()), predicted_end);
  }

 private:
  static inverse::FitOptions fit_options(const std::string& device) {
    inverse::FitOptions fit;
    fit.solver.backend.device = device;
    fit.solver.backend.precision = forward::Precision::double_precision;
    fit.solver.backend.solve = {1e-7, 200};
    return fit;
  }

  /// E of the fitted volume moved by `change`.
  double validation_error(const Eigen::VectorXd& change) {
    const synthetic::Truth& truth = usual_.truth();
    const Medium medium = inverse::to_medium(fields_of(fit_.fitted() + change), best_.grid);
    std::map<std::string, double> by_channel;
    synthetic::truth_error(std::vector<Medium>(truth.channels.size(), medium), truth,
                           usual_.truth_folder(), options_.device, progress_, &by_channel);
    return by_channel.at(truth.channels[channel]);
  }

  const RigNeedsOptions& options_;
  std::uint64_t seed_;
  Progress& progress_;
  std::mt19937_64 random_;
  RigTrial shot_;   ///< with all exposures
  RigTrial usual_;  ///< with the usual ones
  SurfaceMeasurements best_;
  DenseFit fit_;
};

}  // namespace

RigNeedsOptions quick_rig_needs() {
  RigNeedsOptions options;
  options.views = {{3, 3}, {15, 6}};
  options.exposures = {2};
  options.rigs = 1;
  return options;
}

Json measure_rig_needs(const RigNeedsOptions& options, Progress& progress) {
  const synthetic::SimulationOptions usual = tiny(options.seed);
  const RigViews rendered{usual.board_views, usual.projector_planes};
  std::vector<Case> views, exposures;
  for (const RigViews& v : options.views) views.emplace_back("views", v, usual_exposures);
  for (const int count : options.exposures) exposures.emplace_back("exposures", rendered, count);
  Case best("true lenses", rendered, usual_exposures);
  for (int r = 0; r < options.rigs; ++r) {
    progress.update("rigs", static_cast<double>(r) / options.rigs, std::to_string(r + 1));
    Rig rig(options, options.seed + static_cast<std::uint64_t>(r), progress);
    rig.best(best);
    for (std::size_t k = 0; k < views.size(); ++k) {
      try {
        rig.views(options.views[k], views[k]);
      } catch (const InputError&) {
        views[k].refuse();
      }
    }
    for (std::size_t k = 0; k < exposures.size(); ++k) {
      rig.exposures(options.exposures[k], exposures[k]);
    }
  }
  Json rows = Json::array();
  for (const auto* cases : {&views, &exposures}) {
    for (const Case& one : *cases) rows.push_back(one.row());
  }
  rows.push_back(best.row());
  return rows;
}

namespace {

void measure(const Request& request, Progress& progress, const Save& save) {
  RigNeedsOptions options = request.size == Size::quick ? quick_rig_needs() : RigNeedsOptions{};
  options.seed = request.seed;
  if (request.device != "auto") options.device = request.device;
  options.folder = request.folder / "sessions";
  const Json rows = measure_rig_needs(options, progress);
  save({{"sample", "tiny"},
        {"channel", "G"},
        {"rigs", options.rigs},
        {"draws", options.draws},
        {"corner_noise_px", options.corner_noise_px},
        {"rows", rows}});
}

}  // namespace

Subject rig_subject() {
  return {"rig",
          "Calibration views and exposures a rig needs (docs/calibration.md, docs/hdr.md)",
          R"(  kappamu-studies rig -o out/            four rigs: six minutes of CPU
  kappamu-studies rig --quick -o out/    one rig, fewer counts: a minute

Simulated rigs of the sample tiny: the change that corners of so many views, or stacks
of so many exposures, bring into measurements, kappa and mu; found by fitting again, and
predicted from the calibration's joint covariance and the merge's variance. The sessions
stay in OUT/sessions and are used again.)",
          {{"rig", "views and exposures", measure}}};
}

}  // namespace kappamu::studies
