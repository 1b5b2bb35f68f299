// Front-lit capture end to end: the lit face is the seen one. What the projector lights must be
// left out of the fit and of the score, and the rest must be enough to find the volumes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/numbers/median.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

using nlohmann::json;

class FrontLitTest : public TemporaryFolderTest {};

TEST_F(FrontLitTest, LitVoxelsAreMaskedAndTheOthersGiveTheVolumes) {
  const std::string capture = (folder() / "capture").string();
  const std::string run = (folder() / "run").string();
  const ProcessResult simulated = kappamu(
      "simulate --sample wax2 --grid 32x24x10 --camera 480x360 --no-validation --holdout 6 -o " +
      capture);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.standard_error;
  const ProcessResult fitted = kappamu("run " + capture + "/session -o " + run);
  ASSERT_EQ(fitted.exit_code, 0) << fitted.standard_error;

  const io::NpyArray light = io::read_npy(folder() / "run/measurements/irradiance.npy");
  const io::NpyArray mask = io::read_npy(folder() / "run/measurements/mask.npy");
  constexpr std::size_t channels = 3;
  ASSERT_EQ(mask.values.size(), channels * light.values.size());
  constexpr float lit = 0.05F;  // a bar's rim; its middle is near 1, the projector's black 2e-4
  std::size_t used = 0;
  for (std::size_t i = 0; i < mask.values.size(); ++i) {
    const bool is_used = mask.values[i] != 0.0F;
    if (light.values[i % light.values.size()] > lit) {
      ASSERT_FALSE(is_used) << i;
    }
    used += is_used ? 1 : 0;
  }
  // A bar and its neighbours cover less than a quarter of the face.
  EXPECT_GT(used, mask.values.size() * 3 / 4);

  const ProcessResult scored = kappamu("score " + run + " --truth " + capture + "/truth --json");
  ASSERT_EQ(scored.exit_code, 0) << scored.standard_error;
  const json score = json::parse(last_line(scored.standard_output));
  // Measured 5.1e-5 on the unlit voxels; every sample's aim is 1e-3.
  constexpr double bound = 4e-4;
  EXPECT_LT(score.at("truth_E").get<double>(), bound);
}

/// One face under the same light from two camera stations: each is measured by its own pose.
TEST_F(FrontLitTest, TwoStationsSeeTheSameFaceAlike) {
  const std::string capture = (folder() / "two").string();
  const std::string run = (folder() / "run").string();
  const ProcessResult simulated = kappamu(
      "simulate --sample wax2 --grid 24x18x8 --camera 480x360 --bars 2 --both-faces --holdout 0 "
      "--no-validation -o " +
      capture);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.standard_error;
  ASSERT_EQ(kappamu("calibrate " + capture + "/session -o " + run).exit_code, 0);
  const ProcessResult merged = kappamu("merge " + capture + "/session -o " + run);
  ASSERT_EQ(merged.exit_code, 0) << merged.standard_error;
  const io::NpyArray value = io::read_npy(folder() / "run/measurements/value.npy");
  const io::NpyArray mask = io::read_npy(folder() / "run/measurements/mask.npy");
  constexpr std::size_t patterns = 4, cells = std::size_t{24} * 18;  // of each station
  ASSERT_EQ(value.values.size(), 3 * 2 * patterns * cells);
  std::vector<double> off;
  for (std::size_t i = 0; i < value.values.size(); ++i) {
    const std::size_t pattern = i / cells % (2 * patterns);
    if (pattern >= patterns) continue;
    const std::size_t other = i + patterns * cells;  // the same light from the other station
    if (mask.values[i] == 0.0F || mask.values[other] == 0.0F) continue;
    off.push_back(std::abs(std::log(value.values[i] / value.values[other])));
  }
  ASSERT_GT(off.size(), patterns * cells);
  constexpr double alike = 0.01;
  EXPECT_LT(upper_median(off), alike);
  const auto measured = json::parse(io::read_text(folder() / "run/measurements/measurements.json"));
  EXPECT_FALSE(measured.contains("seen_faces"));  // there is one
}

}  // namespace
}  // namespace kappamu::app
