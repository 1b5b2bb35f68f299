#include "bench/calibration/rig_needs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "bench/calibration/rig_trial.h"
#include "bench/inverse/dense_fit.h"
#include "core/error.h"
#include "core/numbers/median.h"
#include "data_synthetic/rig/rig.h"
#include "data_synthetic/score.h"

namespace kappamu::bench {

namespace {

constexpr int all_exposures = 9;
constexpr int usual_exposures = 5;
constexpr int channel = 1;                   // G
constexpr double median_of_normal = 0.6745;  // of |x| of deviation 1

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

/// All that is measured of one case, to become medians.
class Samples {
 public:
  void add(double RigCase::*what, double value) { values_[index_of(what)].push_back(value); }
  void add(const Changes& found) {
    add(&RigCase::kappa, found.kappa);
    add(&RigCase::mu, found.mu);
  }
  void add_predicted(const Changes& predicted) {
    add(&RigCase::kappa_predicted, predicted.kappa);
    add(&RigCase::mu_predicted, predicted.mu);
  }
  void add(const synthetic::CalibrationErrors& errors) {
    add(&RigCase::camera_px, errors.camera_face_px);
    add(&RigCase::projector_px, errors.projector_face_px);
    add(&RigCase::turn_degrees, errors.camera_angle_degrees);
    add(&RigCase::scale, errors.scale_relative);
  }
  void into(RigCase& one) const {
    for (std::size_t k = 0; k < quantities.size(); ++k) {
      if (!values_[k].empty()) one.*quantities[k] = median(values_[k]);
    }
  }

 private:
  static constexpr std::array quantities{&RigCase::camera_px,    &RigCase::projector_px,
                                         &RigCase::turn_degrees, &RigCase::scale,
                                         &RigCase::value,        &RigCase::kappa,
                                         &RigCase::mu,           &RigCase::kappa_predicted,
                                         &RigCase::mu_predicted, &RigCase::validation_E};
  static std::size_t index_of(double RigCase::*what) {
    return static_cast<std::size_t>(std::find(quantities.begin(), quantities.end(), what) -
                                    quantities.begin());
  }
  std::array<std::vector<double>, quantities.size()> values_;
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

  void best(Samples& samples) {
    const synthetic::Truth& truth = usual_.truth();
    samples.add(synthetic::calibration_errors(usual_.calibrated(true_lenses(truth)), truth));
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(fit_.unknowns());
    samples.add(&RigCase::validation_E, held_out(none));
    const Medium expected =
        synthetic::true_medium(truth, usual_.truth_folder(), truth.channels[channel]);
    samples.add(of_median_voxel(fit_.fitted() - joined(inverse::to_fields(expected))));
  }

  /// Throws InputError where the calibration does.
  void views(const RigViews& views, Samples& samples) {
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
    samples.add(synthetic::calibration_errors(calibration, usual_.truth()));
    samples.add(&RigCase::value, relative_change(found, best_));
    const Eigen::VectorXd change = fit_.refitted(found);
    samples.add(of_median_voxel(change));
    samples.add(&RigCase::validation_E, held_out(change));
    const Eigen::VectorXd linear = fit_.change(found);
    std::vector<double> kappa;
    std::vector<double> mu;
    for (int draw = 0; draw < options_.draws; ++draw) {
      const SurfaceMeasurements other = usual_.measured(usual_.calibrated(drawn(joint, random_)));
      const Changes predicted = of_median_voxel(fit_.change(other) - linear);
      kappa.push_back(predicted.kappa);
      mu.push_back(predicted.mu);
    }
    samples.add_predicted({median(kappa), median(mu)});
  }

  void exposures(int count, Samples& samples) {
    const RigTrial own = shot_.with_exposures(count);
    const calib::CalibrationResult& calibration = own.calibration();
    const SurfaceMeasurements found = own.measured(calibration);
    const SurfaceMeasurements exact = own.exact(calibration);
    samples.add(synthetic::calibration_errors(calibration, own.truth()));
    samples.add(&RigCase::value, relative_change(found, exact));
    const Eigen::VectorXd change = fit_.refitted(found);
    samples.add(of_median_voxel(change - fit_.refitted(exact)));
    samples.add(&RigCase::validation_E, held_out(change));
    const Variances noise = fit_.propagated(own.measured(calibration, {0.0, 0.0}));
    samples.add_predicted(of_median_voxel(median_of_normal * noise.cwiseSqrt()));
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
  double held_out(const Eigen::VectorXd& change) {
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

RigNeeds measure_rig_needs(const RigNeedsOptions& options, Progress& progress) {
  std::vector<Samples> views(options.views.size());
  std::vector<Samples> exposures(options.exposures.size());
  Samples best;
  RigNeeds needs;
  for (const RigViews& v : options.views) {
    needs.views.push_back({});
    needs.views.back().views = v;
    needs.views.back().exposures = usual_exposures;
  }
  const synthetic::SimulationOptions usual = tiny(options.seed);
  for (const int count : options.exposures) {
    needs.exposures.push_back({});
    needs.exposures.back().views = {usual.board_views, usual.projector_planes};
    needs.exposures.back().exposures = count;
  }
  for (int r = 0; r < options.rigs; ++r) {
    progress.update("rigs", static_cast<double>(r) / options.rigs, std::to_string(r + 1));
    Rig rig(options, options.seed + static_cast<std::uint64_t>(r), progress);
    rig.best(best);
    for (std::size_t k = 0; k < views.size(); ++k) {
      try {
        rig.views(options.views[k], views[k]);
      } catch (const InputError&) {
        ++needs.views[k].refused;
      }
    }
    for (std::size_t k = 0; k < exposures.size(); ++k) {
      rig.exposures(options.exposures[k], exposures[k]);
    }
  }
  best.into(needs.best);
  for (std::size_t k = 0; k < views.size(); ++k) views[k].into(needs.views[k]);
  for (std::size_t k = 0; k < exposures.size(); ++k) exposures[k].into(needs.exposures[k]);
  return needs;
}

namespace {

Json to_json(const std::string& part, const RigCase& c) {
  return {{"part", part},
          {"boards", c.views.boards},
          {"planes", c.views.planes},
          {"exposures", c.exposures},
          {"refused", c.refused},
          {"camera_px", c.camera_px},
          {"projector_px", c.projector_px},
          {"turn_degrees", c.turn_degrees},
          {"scale_relative", c.scale},
          {"value_relative", c.value},
          {"log_kappa", c.kappa},
          {"log_kappa_predicted", c.kappa_predicted},
          {"log_mu", c.mu},
          {"log_mu_predicted", c.mu_predicted},
          {"validation_E", c.validation_E}};
}

void measure(const Request& request, Progress& progress, const Save& save) {
  RigNeedsOptions options = request.size == Size::quick ? quick_rig_needs() : RigNeedsOptions{};
  options.seed = request.seed;
  if (request.device != "auto") options.device = request.device;
  options.folder = request.folder / "sessions";
  options.corner_noise_px = request.number("corner-noise", options.corner_noise_px);
  options.rigs = request.count("rigs", options.rigs);
  const RigNeeds needs = measure_rig_needs(options, progress);
  Json rows = Json::array({to_json("true lenses", needs.best)});
  for (const RigCase& c : needs.views) rows.push_back(to_json("views", c));
  for (const RigCase& c : needs.exposures) rows.push_back(to_json("exposures", c));
  save({{"sample", "tiny"},
        {"channel", "G"},
        {"rigs", options.rigs},
        {"draws", options.draws},
        {"corner_noise_px", options.corner_noise_px},
        {"rows", rows}});
}

}  // namespace

Subject rig_subject() {
  return {
      "rig",
      "Calibration views and exposures a rig needs (docs/calibration.md, docs/hdr.md)",
      "  kappamu bench rig -o out/            four rigs: six minutes of CPU\n"
      "  kappamu bench rig --quick -o out/    one rig, fewer counts: a minute\n\n"
      "Simulated rigs of the sample tiny: the change that corners of so many views, or stacks\n"
      "of so many exposures, bring into measurements, kappa and mu; found by fitting again, and\n"
      "predicted from the calibration's joint covariance and the merge's variance. The sessions\n"
      "stay in OUT/sessions and are used again.",
      {{"rig", "views and exposures", measure}},
      {{"corner-noise",
        "Standard deviation of a board's corner, per coordinate [camera px] (default 0.1)",
        Setting::Kind::number, 1e-3, 1.0},
       {"rigs", "Rigs, with seeds from --seed on (default 4)", Setting::Kind::number, 1, 1000}}};
}

}  // namespace kappamu::bench
