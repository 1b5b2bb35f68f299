// Flicker, drift, mislabelled exposures and moved samples: found where they are, by how much, and
// not found where they are not. Prints the edges of docs/limits.md.
#include "capture/radiance/steadiness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "capture/radiance/merge.h"
#include "capture/session/frames.h"
#include "io/image/image_file.h"
#include "tests/capture/session_files.h"
#include "tests/capture/simulated_camera.h"
#include "tests/sentence.h"

namespace kappamu::capture {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int width = 320;
constexpr int height = 240;

// The default noise: what `kappamu simulate` and the documented session have.
const SimulatedCamera default_camera{12, 40.0, 20000.0, 5.0, straight_curve};

Radiometry linear_radiometry() {
  Radiometry radiometry;
  radiometry.bit_depth = 12;
  radiometry.black_level = {40.0};
  radiometry.response.linear = {linear_response(12, 40.0)};
  radiometry.noise = {{20000.0, 5.0, false}};
  return radiometry;
}

// A lit patch seen through a translucent block: a bell over a dark ground, a little texture.
double bell(double x, double y) {
  const double dx = (x - 0.45 * width) / 60.0;
  const double dy = (y - 0.55 * height) / 45.0;
  const double texture = 1.0 + 0.1 * std::sin(0.21 * x) * std::sin(0.17 * y);
  return (0.002 + 2.0 * std::exp(-0.5 * (dx * dx + dy * dy))) * texture;
}

Image<float> scene(double shift_x = 0.0, double shift_y = 0.0) {
  Image<float> radiance(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      radiance(x, y) = static_cast<float>(bell(x - shift_x, y - shift_y));
    }
  }
  return radiance;
}

const std::vector<double> times{1.0 / 30.0, 0.1, 0.3, 1.0, 3.0};

struct Disturbance {
  std::vector<double> gain = std::vector<double>(times.size(), 1.0);
  std::vector<double> shift = std::vector<double>(times.size(), 0.0);  // along x [px]
};

std::vector<ExposedFrame> shoot(const Disturbance& disturbed, unsigned seed) {
  std::vector<ExposedFrame> stack;
  for (std::size_t j = 0; j < times.size(); ++j) {
    Image<float> radiance = scene(disturbed.shift[j]);
    for (float& value : radiance.values()) value *= static_cast<float>(disturbed.gain[j]);
    stack.push_back(shoot_stack(default_camera, radiance, {times[j]},
                                seed * 101 + static_cast<unsigned>(j))[0]);
  }
  return stack;
}

const std::vector<std::string> files{"f0.png", "f1.png", "f2.png", "f3.png", "f4.png"};

std::vector<Fault> faults_of(const Disturbance& disturbed, unsigned seed) {
  return find_faults(compare_frames(shoot(disturbed, seed), linear_radiometry()), times, files, {});
}

TEST(Steadiness, SteadyStacksAreNotBlamed) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const Fault& fault : faults_of({}, seed)) ADD_FAILURE() << seed << ": " << fault.sentence;
    for (const auto& state : compare_frames(shoot({}, seed), linear_radiometry())) {
      EXPECT_TRUE(state) << "every frame has something in common with the next";
    }
  }
}

// What is found is what was put in, and as uncertain as it says: deviations over 20 stacks in units
// of the predicted deviation.
TEST(Steadiness, GainAndShiftAreFoundWithinTheirErrors) {
  Disturbance disturbed;
  disturbed.gain[1] = 1.02;
  disturbed.shift[3] = 0.3;
  double gain_squares = 0.0;
  double shift_squares = 0.0;
  constexpr int stacks = 20;
  for (unsigned seed = 0; seed < stacks; ++seed) {
    const Steadiness found = compare_frames(shoot(disturbed, seed), linear_radiometry());
    for (const std::size_t frame : {std::size_t{1}, std::size_t{3}}) ASSERT_TRUE(found[frame]);
    const double gain = found[1]->log_gain - std::log(1.02);
    const double shift = found[3]->shift_px[0] - 0.3;
    gain_squares += gain * gain / (found[1]->log_gain_sigma * found[1]->log_gain_sigma) / stacks;
    shift_squares += shift * shift / (found[3]->shift_sigma_px * found[3]->shift_sigma_px) / stacks;
    EXPECT_NEAR(gain, 0.0, 0.002);
    EXPECT_NEAR(shift, 0.0, 0.05);
  }
  std::printf("root mean square error / predicted deviation: gain %.2f, shift %.2f\n",
              std::sqrt(gain_squares), std::sqrt(shift_squares));
  // The 2 permille floor of a block makes the prediction a little large; never half too small.
  EXPECT_LT(std::sqrt(gain_squares), 1.5);
  EXPECT_LT(std::sqrt(shift_squares), 1.5);
}

// The equations hold for small shifts alone.
TEST(Steadiness, LargeShiftsAreFoundWithinTheirErrors) {
  for (const double shift : {2.4, -7.3}) {
    Disturbance disturbed;
    disturbed.shift[3] = shift;
    const Steadiness found = compare_frames(shoot(disturbed, 1), linear_radiometry());
    ASSERT_TRUE(found[3]);
    constexpr double deviations = 4.0;
    EXPECT_NEAR(found[3]->shift_px[0], shift, deviations * found[3]->shift_sigma_px);
    EXPECT_LT(found[3]->shift_sigma_px, 0.02);
  }
}

// The smallest flicker and shift of one frame that every one of ten stacks shows.
TEST(Steadiness, EdgesAtDefaultNoise) {
  const auto found_in_all = [](const Disturbance& disturbed, Fault::Kind kind, std::size_t frame) {
    for (unsigned seed = 0; seed < 10; ++seed) {
      const std::vector<Fault> faults = faults_of(disturbed, seed);
      if (faults.size() != 1 || faults[0].kind != kind || faults[0].frame != frame) return false;
    }
    return true;
  };
  double least_gain = 0.0;
  for (const double percent : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0}) {
    Disturbance disturbed;
    disturbed.gain[2] = 1.0 + 0.01 * percent;
    if (!found_in_all(disturbed, Fault::Kind::flicker, 2)) continue;
    least_gain = percent;
    break;
  }
  double least_shift = 0.0;
  for (const double shift : {0.05, 0.08, 0.1, 0.12, 0.15, 0.2, 0.3}) {
    Disturbance disturbed;
    disturbed.shift[2] = shift;
    if (!found_in_all(disturbed, Fault::Kind::moved, 2)) continue;
    least_shift = shift;
    break;
  }
  double least_drift = 0.0;
  for (const double percent : {0.5, 0.8, 1.0, 1.2, 1.5, 2.0}) {
    Disturbance disturbed;
    for (std::size_t j = 0; j < times.size(); ++j) {
      disturbed.gain[j] = 1.0 + 0.01 * percent * static_cast<double>(j) / 4.0;
    }
    if (!found_in_all(disturbed, Fault::Kind::drift, 4)) continue;
    least_drift = percent;
    break;
  }
  double least_label = 0.0;
  for (const double percent : {8.0, 12.0, 15.0, 16.0, 17.0, 18.0, 20.0}) {
    Disturbance disturbed;  // what an exposure time told too short by as much looks like
    disturbed.gain[2] = 1.0 + 0.01 * percent;
    if (!found_in_all(disturbed, Fault::Kind::mislabelled, 2)) continue;
    least_label = percent;
    break;
  }
  std::printf(
      "edges: flicker %.1f %%, drift over the stack %.1f %%, shift %.2f px, exposure time %.0f "
      "%%\n",
      least_gain, least_drift, least_shift, least_label);
  // The tolerances are 0.5 %, twice that over the stack, and 0.1 px; noise may add a fifth.
  EXPECT_NEAR(least_gain, 0.6, 0.1001);
  EXPECT_NEAR(least_drift, 1.2, 0.2001);
  EXPECT_NEAR(least_shift, 0.12, 0.0301);
  EXPECT_NEAR(least_label, 17.0, 1.01);  // ln 1.162 = 0.15
}

// The smallest square of one frame, 15 % darker, that every one of ten stacks shows.
TEST(Steadiness, EdgeOfAChangedPart) {
  constexpr float darkened = 0.85F;
  int least_edge = 0;
  double least_share = 0.0;
  for (const int edge : {16, 24, 32, 40, 48, 56, 64, 80}) {
    Image<float> shaded = scene();
    for (int y = 132 - edge / 2; y < 132 + edge / 2; ++y) {
      for (int x = 144 - edge / 2; x < 144 + edge / 2; ++x) shaded(x, y) *= darkened;
    }
    int found = 0;
    double share = 0.0;
    for (unsigned seed = 0; seed < 10; ++seed) {
      std::vector<ExposedFrame> stack = shoot({}, seed);
      stack[2] = shoot_stack(default_camera, shaded, {times[2]}, seed * 101 + 2)[0];
      const Steadiness states = compare_frames(stack, linear_radiometry());
      const std::vector<Fault> faults = find_faults(states, times, files, {});
      if (faults.size() != 1 || faults[0].kind != Fault::Kind::changed || faults[0].frame != 2)
        break;
      share += 0.1 * states[2]->changed_share;
      ++found;
    }
    if (found < 10) continue;
    least_edge = edge;
    least_share = share;
    break;
  }
  std::printf("edge: a square of %d px, 15 %% darker; reported as %.1f %% of the blocks compared\n",
              least_edge, 100.0 * least_share);
  EXPECT_GT(least_edge, 0);
  EXPECT_LE(least_edge, 64);
}

TEST(Steadiness, AMislabelledExposureIsToldWithTheOneThatFits) {
  std::vector<ExposedFrame> stack = shoot({}, 3);
  stack[1].exposure_s = 0.2;  // in truth 0.1
  std::vector<double> told = times;
  told[1] = 0.2;
  const std::vector<Fault> faults =
      find_faults(compare_frames(stack, linear_radiometry()), told, files, {});
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Fault::Kind::mislabelled);
  EXPECT_EQ(faults[0].frame, 1U);
  EXPECT_THAT(faults[0].sentence, HasSubstr("fits an exposure time of 0.1 s"));
}

// The lens covered, or the shutter closed, in one photograph of a lit stack, at whichever exposure.
TEST(Steadiness, ABlackFrameAmongLitOnesIsTold) {
  for (const std::size_t black : {2U, 3U, 4U}) {
    std::vector<ExposedFrame> stack = shoot({}, 7);
    stack[black] = shoot_stack(default_camera, Image<float>(width, height, 1, 0.0F), {times[black]},
                               static_cast<unsigned>(black))[0];
    const Steadiness found = compare_frames(stack, linear_radiometry());
    const std::vector<Fault> faults = find_faults(found, times, files, {});
    ASSERT_EQ(faults.size(), 1U) << black;
    EXPECT_EQ(faults[0].kind, Fault::Kind::blank);
    EXPECT_EQ(faults[0].frame, black);
    EXPECT_THAT(faults[0].sentence, HasSubstr("it is black where the other frames"));
    EXPECT_EQ(steady_exposures(found, times)[black], times[black]);
  }
}

TEST(Steadiness, AHandBeforeTheLensIsToldAsSuch) {
  std::vector<ExposedFrame> stack = shoot({}, 5);
  for (int y = 100; y < 160; ++y) {
    for (int x = 120; x < 180; ++x) stack[2].pixels(x, y) = 60;
  }
  const std::vector<Fault> faults =
      find_faults(compare_frames(stack, linear_radiometry()), times, files, {});
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].kind, Fault::Kind::changed);
  EXPECT_EQ(faults[0].frame, 2U);
}

// An even, dim scene, every block near the least signal that is compared: nothing that chooses or
// weights blocks may lean on their noise.
TEST(Steadiness, DimEvenStacksAreNotBlamed) {
  for (const float radiance : {0.003F, 0.006F, 0.012F, 0.03F}) {
    for (unsigned seed = 0; seed < 5; ++seed) {
      const auto stack =
          shoot_stack(default_camera, Image<float>(width, height, 1, radiance), times, 40 + seed);
      const Steadiness found = compare_frames(stack, linear_radiometry());
      for (const Fault& fault : find_faults(found, times, files, {})) {
        ADD_FAILURE() << radiance << ", " << seed << ": " << fault.sentence;
      }
    }
  }
}

TEST(Steadiness, DarkStacksSayNothing) {
  const auto stack = shoot_stack(default_camera, Image<float>(width, height, 1, 0.0F), times, 9);
  for (const auto& state : compare_frames(stack, linear_radiometry())) EXPECT_FALSE(state);
}

// From files: refused by name, corrected or ignored as asked.
class UnsteadySession : public testing::Test {
 protected:
  UnsteadySession() {
    session.folder = folder.path();
    session.channels = {"Y"};
    session.camera.width = width;
    session.camera.height = height;
    session.camera.bit_depth = 12;
  }
  void write(const std::vector<ExposedFrame>& frames) {
    for (std::size_t j = 0; j < frames.size(); ++j) {
      io::write_code_image(folder.path() / files[j], frames[j].pixels, 12);
      stack.push_back({files[j], times[j]});
    }
  }
  HdrImage merge(OnFault on_flicker, OnFault on_motion) {
    MergeOptions options;
    options.on_flicker = on_flicker;
    options.on_motion = on_motion;
    notes.clear();
    return merge_stack(session, stack, "pattern fit_00", linear_radiometry(), options, &notes);
  }
  // Mean relative error of the merged radiance where every frame sees it.
  static double error_of(const HdrImage& merged) {
    const Image<float> truth = scene();
    double sum = 0.0;
    double light = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (truth.values()[i] > 0.25F) continue;
      sum += merged.radiance.values()[i] - truth.values()[i];
      light += truth.values()[i];
    }
    return sum / light;
  }

  OwnFolder folder;
  Session session;
  Stack stack;
  std::vector<std::string> notes;
};

TEST_F(UnsteadySession, FlickerIsRefusedCorrectedOrIgnored) {
  Disturbance disturbed;
  disturbed.gain[4] = 1.04;  // the longest frame, which rules the merge
  write(shoot(disturbed, 1));
  EXPECT_THAT(
      sentence_of([&] { merge(OnFault::refuse, OnFault::refuse); }),
      AllOf(StartsWith((folder.path() / "f4.png").string() + ": its light is 4.0 %"),
            HasSubstr("brighter"), HasSubstr("pattern fit_00"), HasSubstr("(on_flicker correct)")));
  // The mean of the frames is kept, 4 % / 5; ignored, the long frame's error is nearly all there.
  EXPECT_NEAR(error_of(merge(OnFault::correct, OnFault::refuse)), 0.008, 0.002);
  EXPECT_THAT(notes, testing::ElementsAre(HasSubstr("its exposure is taken from the frames.")));
  EXPECT_GT(error_of(merge(OnFault::ignore, OnFault::refuse)), 0.02);
  EXPECT_TRUE(notes.empty());
}

TEST_F(UnsteadySession, AMislabelledExposureIsCorrected) {
  write(shoot({}, 1));
  stack[3].exposure_s = 2.0;  // in truth 1 s
  EXPECT_THAT(sentence_of([&] { merge(OnFault::refuse, OnFault::refuse); }),
              AllOf(HasSubstr("fits an exposure time of 1 s"), HasSubstr("not the 2 s stated"),
                    HasSubstr("correct exposure_s in session.json")));
  EXPECT_NEAR(error_of(merge(OnFault::correct, OnFault::refuse)), 0.0, 0.002);
}

TEST_F(UnsteadySession, AMovedFrameIsRefusedOrLeftOut) {
  Disturbance disturbed;
  disturbed.shift[1] = 3.0;
  write(shoot(disturbed, 1));
  EXPECT_THAT(sentence_of([&] { merge(OnFault::refuse, OnFault::refuse); }),
              AllOf(StartsWith((folder.path() / "f1.png").string() + ": its picture is shifted by"),
                    HasSubstr("moved"), HasSubstr("(on_motion correct, on_motion align)")));
  EXPECT_NEAR(error_of(merge(OnFault::refuse, OnFault::correct)), 0.0, 0.002);
  EXPECT_THAT(notes, testing::ElementsAre(HasSubstr("the frame is left out.")));
}

TEST_F(UnsteadySession, ShiftedFramesAreMovedBack) {
  Disturbance disturbed;
  disturbed.shift = {0.0, 2.3, -1.6, 0.0, 5.0};
  write(shoot(disturbed, 1));
  EXPECT_LT(std::abs(error_of(merge(OnFault::refuse, OnFault::align))), 0.003);
  EXPECT_EQ(notes.size(), 3U);
  EXPECT_THAT(notes, testing::Each(HasSubstr("the frame is moved back.")));
  // Pixel by pixel: an edge that was blurred over two pixels before is where it belongs.
  const auto worst = [&](OnFault on_motion) {
    const HdrImage merged = merge(OnFault::ignore, on_motion);
    const Image<float> truth = scene();
    double square = 0.0;
    for (int y = 10; y < height - 10; ++y)
      for (int x = 10; x < width - 10; ++x)
        square += std::pow(merged.radiance(x, y) / truth(x, y) - 1.0, 2) * (truth(x, y) > 0.02F);
    return std::sqrt(square);
  };
  EXPECT_LT(worst(OnFault::align), 0.2 * worst(OnFault::ignore));
  const HdrImage merged = merge(OnFault::refuse, OnFault::align);
  EXPECT_EQ(merged.flags(width - 1, 20) & pixel_missing, pixel_missing);
  EXPECT_EQ(merged.flags(0, 20) & pixel_missing, pixel_missing);
  EXPECT_EQ(merged.flags(width / 2, 20) & pixel_missing, 0);
}

TEST_F(UnsteadySession, TooManyMovedFramesAreRefusedEvenWhenAskedToCorrect) {
  Disturbance disturbed;
  disturbed.shift = {0.0, 2.0, 4.0, 6.0, 8.0};
  write(shoot(disturbed, 1));
  EXPECT_THAT(sentence_of([&] { merge(OnFault::correct, OnFault::correct); }),
              HasSubstr("too many to leave out; photograph the stack again"));
}

TEST_F(UnsteadySession, AmongEqualExposuresFlickerMotionAndCopiesAreTold) {
  const auto shot = [&](double gain, double shift, unsigned seed) {
    Image<float> radiance = scene(shift);
    for (float& value : radiance.values()) value *= static_cast<float>(gain);
    return shoot_stack(default_camera, radiance, {0.3}, seed)[0];
  };
  const auto merged = [&](const std::vector<ExposedFrame>& frames) {
    stack.clear();
    write(frames);
    for (Frame& frame : stack) frame.exposure_s = 0.3;
    return merge(OnFault::refuse, OnFault::refuse);
  };
  EXPECT_NEAR(error_of(merged({shot(1, 0, 1), shot(1, 0, 2), shot(1, 0, 3)})), 0.0, 0.002);
  EXPECT_THAT(sentence_of([&] {
                merged({shot(1, 0, 1), shot(1.04, 0, 2), shot(1, 0, 3)});
              }),
              AllOf(HasSubstr("f1.png"), HasSubstr("brighter")));
  EXPECT_THAT(sentence_of([&] {
                merged({shot(1, 0, 1), shot(1, 0, 2), shot(1, 2, 3)});
              }),
              AllOf(HasSubstr("f2.png"), HasSubstr("shifted by")));
  EXPECT_THAT(sentence_of([&] {
                merged({shot(1, 0, 1), shot(1, 0, 2), shot(1, 0, 1)});
              }),
              AllOf(HasSubstr("f2.png: is a copy of f0.png"), HasSubstr("pattern fit_00")));
}

}  // namespace
}  // namespace kappamu::capture
