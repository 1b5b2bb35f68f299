// What a rig adds to the error of κ and μ: the draws from a calibration are its spread, fewer views
// cost more, and what is predicted is of the size of what is found.
#include "studies/calibration/rig_needs.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "data_synthetic/rig/rig.h"
#include "studies/calibration/rig_trial.h"
#include "tests/data_synthetic/tiny_options.h"
#include "tests/studies/bench_tools.h"

namespace kappamu::studies {
namespace {

struct Spread {
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  double deviation() const { return std::sqrt((squares - sum * sum / count) / (count - 1)); }
};

// Both lenses' focal lengths, and the projector's place, over repeated calibrations of one rig.
TEST(RigTrial, DrawnRigsSpreadAsRepeatedCalibrationsDo) {
  synthetic::SimulationOptions options = synthetic::tiny_options();
  options.projector_planes = 3;
  const synthetic::Rig rig = synthetic::make_rig(options);
  std::mt19937_64 random(1);
  std::array<Spread, 3> found;
  std::array<Spread, 3> drawn_spread;
  const auto add = [](const Lenses& lenses, std::array<Spread, 3>& to) {
    to[0].add(lenses.camera.fx);
    to[1].add(lenses.projector.fx);
    to[2].add(lenses.projector_from_station.translation.z());
  };
  for (int k = 0; k < 16; ++k) {
    const calib::JointCalibration joint = calibrate_corners(rig, 0.1, random);
    add({joint.camera.lens, joint.projector.lens, joint.projector.projector_from_station}, found);
    // Of one calibration only: what all of them differ in besides is what is found.
    for (int draw = 0; draw < 16 && k == 0; ++draw) add(drawn(joint, random), drawn_spread);
  }
  for (std::size_t q = 0; q < 3; ++q) {
    std::printf("found %.3f, drawn %.3f\n", found[q].deviation(), drawn_spread[q].deviation());
    // Sixteen know a deviation to 18 %.
    EXPECT_NEAR(std::log(drawn_spread[q].deviation() / found[q].deviation()), 0.0, std::log(2.0));
  }
}

class RigNeedsTest : public FolderTest {};

TEST_F(RigNeedsTest, FewViewsAndExposuresCostWhatIsPredicted) {
  RigNeedsOptions options = quick_rig_needs();
  options.folder = folder();
  Progress silent;
  const Json rows = measure_rig_needs(options, silent);
  ASSERT_EQ(rows.size(), 4U);
  const auto figure = [&](std::size_t row, const char* name) {
    return rows.at(row).at(name).get<double>();
  };
  constexpr std::size_t few = 0, many = 1, two = 2;  // views, views, exposures
  EXPECT_EQ(figure(few, "refused") + figure(many, "refused"), 0);
  EXPECT_GT(figure(few, "camera_px"), 2.0 * figure(many, "camera_px"));
  EXPECT_GT(figure(few, "value_relative"), 2.0 * figure(many, "value_relative"));
  EXPECT_GT(figure(few, "log_kappa"), 1e-3);
  // One calibration and two draws from it tell little more than the order.
  for (const std::string name : {"log_kappa", "log_mu"}) {
    const double predicted = figure(few, (name + "_predicted").c_str());
    EXPECT_NEAR(std::log(predicted / figure(few, name.c_str())), 0.0, std::log(4.0)) << name;
  }
  // The response's error comes on top.
  EXPECT_GT(figure(two, "log_kappa"), 0.5 * figure(two, "log_kappa_predicted"));
  EXPECT_GT(figure(two, "log_kappa_predicted"), 1e-3);
}

}  // namespace
}  // namespace kappamu::studies
