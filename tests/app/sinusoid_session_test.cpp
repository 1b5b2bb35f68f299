// A front-lit session under sinusoids through the whole product: simulated by Monte Carlo transport
// with anisotropic scattering, calibrated and mapped by `kappamu map`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/read_file.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;

class SinusoidSession : public TemporaryFolderTest {};

// 31 s of processor time on two cores, most of it photons.
TEST_F(SinusoidSession, PhantomIsFoundWithinItsDeviations) {
  const std::string simulated = (folder() / "simulated").string();
  const ProcessResult made = kappamu(
      "simulate --sample phantom --grid 32x32x16 --camera 400x300 --boards 12 --planes 8 "
      "--sinusoids 0.2 --phases 3 --transport montecarlo --anisotropy 0.9 --photons 40000 "
      "--no-validation --holdout 0 --encoding linear --projector-levels 3 -o " +
      simulated);
  ASSERT_EQ(made.exit_code, 0) << made.standard_error;
  const std::string maps = (folder() / "maps").string();
  const ProcessResult mapped = kappamu("map " + simulated + "/session -o " + maps +
                                       " --anisotropy 0.9 --anisotropy-deviation 0.02");
  ASSERT_EQ(mapped.exit_code, 0) << mapped.standard_error;
  const auto summary = nlohmann::json::parse(io::read_text(fs::path(maps) / "summary.json"));
  constexpr std::array<double, 3> mua{0.03, 0.05, 0.08}, musp{2.0, 2.2, 2.4};
  // The simulator's own photons leave the middle of the face uncertain by as much.
  constexpr double photons_mua = 0.04, photons_musp = 0.015;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto& map = summary.at("wavelengths").at(c);
    EXPECT_EQ(map.at("channel"), std::string(1, "RGB"[c]));
    EXPECT_NEAR(map.at("pictures").at(0).at("per_mm").get<double>(), 0.2, 0.002);
    const auto& region = map.at("region");
    const double a = region.at("mua"), s = region.at("musp");
    EXPECT_LT(std::abs(a / mua[c] - 1.0),
              2.0 * std::hypot(region.at("mua_deviation").get<double>() / a, photons_mua))
        << region;
    EXPECT_LT(std::abs(s / musp[c] - 1.0),
              2.0 * std::hypot(region.at("musp_deviation").get<double>() / s, photons_musp))
        << region;
  }
}

TEST_F(SinusoidSession, SimulatorRefusesAnisotropyOfDiffusion) {
  const ProcessResult refused =
      kappamu("simulate --sample phantom --sinusoids 0.2 --anisotropy 0.9 -o " +
              (folder() / "none").string());
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_THAT(refused.standard_error, testing::HasSubstr("diffusion knows reduced scattering"));
}

}  // namespace
}  // namespace kappamu::app
