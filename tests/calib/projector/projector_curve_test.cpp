// The projector's response: the curve between measured values, and a simulated session in a room
// that is not dark whose projector has a gamma, against the simulator's truth.
#include "calib/projector/projector_curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "calib/calibrate.h"
#include "calib/calibration_file.h"
#include "calib/measure.h"
#include "capture/radiance/ambient.h"
#include "capture/radiance/merge.h"
#include "capture/rig/shoot.h"
#include "data_synthetic/simulate.h"
#include "data_synthetic/truth.h"
#include "io/image/image_file.h"
#include "tests/data_synthetic/tiny_options.h"
#include "tests/own_folder.h"

namespace kappamu::calib {
namespace {

using ::testing::HasSubstr;

ProjectorCurve power_curve(int levels, double exponent) {
  std::vector<int> values{0};
  std::vector<std::vector<double>> signals{{2.0}};  // black, with the room's light
  for (const int value : capture::projector_levels(levels)) values.push_back(value);
  values.push_back(255);
  for (std::size_t k = 1; k < values.size(); ++k) {
    signals.push_back({2.0 + 5.0 * std::pow(values[k] / 255.0, exponent)});
  }
  return curve_from_signals(values, signals);
}

TEST(ProjectorCurve, RunsThroughTheMeasuredValuesAndRises) {
  const ProjectorCurve curve = power_curve(5, 2.2);
  const LightTable table = light_table(curve);
  for (std::size_t k = 0; k < curve.values.size(); ++k) {
    EXPECT_FLOAT_EQ(table[static_cast<std::size_t>(curve.values[k])],
                    static_cast<float>(curve.light[0][k]));
  }
  for (std::size_t value = 1; value < table.size(); ++value) {
    EXPECT_GT(table[value], table[value - 1]) << value;
  }
  EXPECT_EQ(light_table(std::nullopt)[51], 0.2F);
  EXPECT_NEAR(power_table(2.2)[128], std::pow(128 / 255.0, 2.2), 1e-7);
}

// What the curve between the values costs: how many values a plan needs.
TEST(ProjectorCurve, NineValuesTellAPowerLaw) {
  for (const int levels : {3, 5, 9, 17}) {
    double worst = 0.0;
    for (const double exponent : {1.0, 1.8, 2.2, 2.6}) {
      const LightTable table = light_table(power_curve(levels, exponent));
      for (std::size_t value = 0; value < table.size(); ++value) {
        const double light = std::pow(static_cast<double>(value) / 255.0, exponent);
        worst = std::max(worst, std::abs(table[value] - light));
      }
    }
    std::printf("%2d values: curve off by %.3f %% of white at most\n", levels, 100.0 * worst);
    if (levels >= 9) {
      EXPECT_LT(worst, 0.002);
    }
  }
}

TEST(ProjectorCurve, ChannelsThatDifferAreTold) {
  const ProjectorCurve curve = curve_from_signals({0, 128, 255}, {{0, 0}, {0.4, 0.5}, {1, 1}});
  EXPECT_NEAR(curve.channel_spread(), 0.05, 1e-12);
  EXPECT_NEAR(curve.mean(1), 0.45, 1e-12);
}

/// Remembers warnings.
class Listener : public Progress {
 public:
  void warn(const std::string& sentence) override { warnings += sentence + "\n"; }
  std::string warnings;
};

class LitRoom : public ::testing::Test {
 protected:
  LitRoom() {
    options = synthetic::tiny_options();
    options.light = capture::FitLight{capture::LightShape::patches, 1};
    options.validation = false;
    options.holdout = 0;
    options.encoding = capture::Encoding::linear;
    options.rays_per_side = 2;
    options.projector_gamma = 2.2;
    options.projector_levels = 9;
    options.room_light = 0.02;
    // A ramp across the lit face: every value.
    Image<std::uint8_t> ramp(options.projector_size[0], options.projector_size[1], 1);
    for (int y = 0; y < ramp.height(); ++y) {
      for (int x = 0; x < ramp.width(); ++x) {
        const double share = (x - 0.25 * ramp.width()) / (0.5 * ramp.width());
        ramp(x, y) = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
      }
    }
    io::write_image(folder / "ramp.png", ramp);
    options.pattern_files = {folder / "ramp.png"};
  }

  const OwnFolder folder;
  synthetic::SimulationOptions options;
};

double relative_l2(const std::vector<float>& found, const std::vector<double>& truth) {
  double error = 0.0;
  double total = 0.0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    error += std::pow(found[k] - truth[k], 2);
    total += truth[k] * truth[k];
  }
  return std::sqrt(error / total);
}

TEST_F(LitRoom, ResponseBlackAndRoomAreToldApart) {
  Listener listener;
  synthetic::simulate(options, folder / "capture", "reference", listener);
  const capture::Session session = capture::read_session(folder / "capture/session");
  const synthetic::Truth truth = synthetic::read_truth(folder / "capture/truth");
  CalibrationResult found = calibrate(session, listener);

  ASSERT_TRUE(found.projector_curve.has_value());
  double worst = 0.0;
  const LightTable table = light_table(found.projector_curve);
  for (std::size_t value = 0; value < table.size(); ++value) {
    worst = std::max(worst, std::abs(table[value] - std::pow(value / 255.0, 2.2)));
  }
  ASSERT_TRUE(found.white.room_light.has_value());
  std::printf(
      "response off by %.3f %% of white, channels apart by %.3f %%; black 1:%.0f "
      "(1:%.0f), room %.4f (%.4f)\n",
      100.0 * worst, 100.0 * found.projector_curve->channel_spread(),
      1.0 / found.white.projector_black, 1.0 / truth.projector.black_level, *found.white.room_light,
      options.room_light);
  EXPECT_LT(worst, 0.004);
  EXPECT_NEAR(found.white.projector_black / truth.projector.black_level, 1.0, 0.1);
  EXPECT_NEAR(*found.white.room_light / options.room_light, 1.0, 0.02);

  save_calibration(folder / "calibration", found);
  const CalibrationResult again = load_calibration(folder / "calibration");
  EXPECT_EQ(again.projector_curve->values, found.projector_curve->values);
  EXPECT_EQ(again.projector_curve->light, found.projector_curve->light);
  EXPECT_EQ(again.white.room_light, found.white.room_light);

  // The ramp's light on the face and what comes through, with and without what was measured.
  synthetic::SimulatedRig rig(options, "reference");
  std::vector<Image<std::uint8_t>> images;
  for (const capture::Pattern& pattern : session.patterns) {
    const Image<std::uint16_t> codes = io::read_code_image(session.folder / pattern.image);
    images.emplace_back(codes.width(), codes.height(), 1);
    std::copy(codes.values().begin(), codes.values().end(), images.back().values().begin());
  }
  rig.prepare(images, listener);
  const GridShape& fine = rig.transport().block().shape;
  const GridShape grid = session.sample.shape();
  const int factor = fine.nx / grid.nx;
  const std::vector<double> light = synthetic::average_cells(
      rig.lit_face_irradiance(images.back()), face_shape(fine, session.sample.lit_face), factor);
  std::vector<double> through;
  for (const auto& channel : rig.exitance(images.back(), session.sample.seen_face)) {
    const auto mean =
        synthetic::average_cells(channel, face_shape(fine, session.sample.seen_face), factor);
    through.insert(through.end(), mean.begin(), mean.end());
  }
  const auto ambient = capture::merge_ambient(session, found.radiometry, {});
  ASSERT_TRUE(ambient.has_value());
  bool dark_room = true;
  const auto measured = [&] {
    return measure_surface(
        session, found, capture::PatternRole::validate,
        [&](const std::string& id) {
          capture::HdrImage picture =
              capture::merge_stack(session, session.patterns.back().frames, id, found.radiometry);
          if (dark_room) capture::take_off(ambient->mean, picture);
          return picture;
        },
        listener);
  };
  const SurfaceMeasurements right = measured();
  EXPECT_THAT(listener.warnings, ::testing::Not(HasSubstr("is not measured")));
  found.projector_curve.reset();
  dark_room = false;
  const SurfaceMeasurements wrong = measured();
  std::printf(
      "ramp: light off by %.4f (as proportional %.4f), exitance by %.4f (room not taken "
      "off %.4f)\n",
      relative_l2(right.irradiance, light), relative_l2(wrong.irradiance, light),
      relative_l2(right.value, through), relative_l2(wrong.value, through));
  EXPECT_LT(relative_l2(right.irradiance, light), 0.01);
  EXPECT_LT(relative_l2(right.value, through), 0.02);
  EXPECT_GT(relative_l2(wrong.irradiance, light), 0.2);
  EXPECT_GT(relative_l2(wrong.value, through), 0.03);
  EXPECT_THAT(listener.warnings,
              HasSubstr("patterns/user_0.png has values between black and white, and how the "
                        "projector's light grows with them is not measured"));
}

}  // namespace
}  // namespace kappamu::calib
