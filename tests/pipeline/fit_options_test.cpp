// The record of a fit's options: complete, so that equal records mean equal volumes.
#include "pipeline/records/fit_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "pipeline/records/versions.h"

namespace kappamu::pipeline {
namespace {

using ::testing::Contains;
using ::testing::Key;
using ::testing::Pair;

TEST(FitOptionsRecord, ChangesWithEveryOptionThatTheVolumesDependOn) {
  const std::vector<std::function<void(FitStageOptions&)>> changes{
      [](auto& o) { o.fit.model = inverse::Model::volume; },
      [](auto& o) {
        o.fit.start = {0.2, 0.01};
      },
      [](auto& o) {
        o.fit.start = {0.1, 0.02};
      },
      [](auto& o) { o.fit.optimiser.method = inverse::Method::wang2008; },
      [](auto& o) { o.fit.optimiser.memory += 1; },
      [](auto& o) { o.fit.optimiser.first_step *= 2; },
      [](auto& o) { o.fit.optimiser.longest_step *= 2; },
      [](auto& o) { o.fit.optimiser.max_backtracks += 1; },
      [](auto& o) { o.fit.optimiser.golden_tolerance *= 2; },
      [](auto& o) { o.fit.optimiser.newton_iterations += 1; },
      [](auto& o) { o.fit.optimiser.newton_forcing *= 2; },
      [](auto& o) { o.fit.coordinates = inverse::Coordinates::smooth; },
      [](auto& o) { o.fit.data_term.loss = inverse::Loss::huber; },
      [](auto& o) { o.fit.data_term.huber_threshold *= 2; },
      [](auto& o) { o.fit.data_term.student_freedom *= 2; },
      [](auto& o) { o.fit.regulariser.kind = inverse::RegulariserKind::huber_tv; },
      [](auto& o) { o.fit.regulariser.edge_slope *= 2; },
      [](auto& o) { o.fit.convention = forward::Convention::wang2008; },
      [](auto& o) { o.fit.weight = 0.0; },
      [](auto& o) { o.fit.first_weight *= 2; },
      [](auto& o) { o.fit.last_weight *= 2; },
      [](auto& o) { o.fit.weight_factor *= 0.5; },
      [](auto& o) { o.fit.restart_steps += 1; },
      [](auto& o) { o.fit.target_chi2 = 1.0 + 1e-12; },
      [](auto& o) { o.fit.stagnation *= 2; },
      [](auto& o) { o.fit.stage_tolerance *= 2; },
      [](auto& o) { o.fit.final_tolerance *= 2; },
      [](auto& o) { o.fit.stage_steps += 1; },
      [](auto& o) { o.fit.max_levels += 1; },
      [](auto& o) { o.fit.correct_grid = false; },
      [](auto& o) { o.fit.model_error.relative *= 2; },
      [](auto& o) { o.fit.model_error.of_maximum *= 2; },
      [](auto& o) { o.fit.coarse_model_error.relative *= 2; },
      [](auto& o) { o.fit.coarse_model_error.of_maximum *= 2; },
      [](auto& o) { o.fit.smooth_length *= 2; },
      [](auto& o) { o.fit.anchor_length *= 2; },
      [](auto& o) { o.fit.metric_probes += 1; },
      [](auto& o) { o.fit.sensitivity_probes += 1; },
      [](auto& o) { o.fit.uncertainty.samples += 1; },
      [](auto& o) { o.fit.uncertainty.steps += 1; },
      [](auto& o) { o.fit.uncertainty.probes += 1; },
      [](auto& o) { o.fit.uncertainty.pooling *= 2; },
      [](auto& o) { o.fit.seed += 1; },
      [](auto& o) { o.fit.backend.device = "reference"; },
      [](auto& o) { o.fit.backend.precision = forward::Precision::double_precision; },
      [](auto& o) { o.fit.backend.solve.tolerance *= 2; },
      [](auto& o) { o.fit.backend.solve.max_iterations += 1; },
      [](auto& o) { o.fit.backend.batch += 1; },
      [](auto& o) { o.fit.backend.refined_tolerance *= 2; },
      [](auto& o) { o.fit.backend.refined_memory_mb *= 2; },
      [](auto& o) { o.channels = {"G"}; },
      [](auto& o) { o.hold_out = "none"; },
      [](auto& o) { o.continue_from = "run/fit"; }};
  const std::string usual = options_json({});
  EXPECT_EQ(usual, options_json({}));
  EXPECT_EQ(options_by_name({}).size(), changes.size()) << "an option without a test";
  for (std::size_t i = 0; i < changes.size(); ++i) {
    FitStageOptions options;
    changes[i](options);
    EXPECT_NE(options_json(options), usual) << "change " << i;
  }
}

TEST(FitOptionsRecord, NamesWhatAReaderLooksFor) {
  FitStageOptions options;
  options.fit.target_chi2 = 1.25;
  EXPECT_THAT(options_by_name(options), Contains(Pair("target_chi2", "1.25")));
  EXPECT_THAT(options_by_name(options), Contains(Pair("optimiser", "lbfgs")));
}

TEST(Versions, ListTheLibrariesThatFiguresDependOn) {
  for (const char* name : {"kappamu", "compiler", "OpenCV", "Ceres", "OpenEXR", "OpenVDB", "Eigen"})
    EXPECT_THAT(pipeline::library_versions(), Contains(Key(name)));
}

}  // namespace
}  // namespace kappamu::pipeline
