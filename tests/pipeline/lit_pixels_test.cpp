// Lit pixels in a fit, end to end: a block under sinusoids by Monte Carlo with g 0.9
// (`kappamu forward`), every pixel lit, fitted by `kappamu fit`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "io/measurements_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "tests/app/process.h"

namespace kappamu::app {
namespace {

namespace fs = std::filesystem;

constexpr GridShape block{40, 40, 24, 0.5};
constexpr double mua = 0.05, musp = 2.0;
constexpr double kappa = 1.0 / (3.0 * (mua + musp));
constexpr std::size_t phases = 3;

class LitPixelsFit : public TemporaryFolderTest {
 protected:
  std::string at(const std::string& name) const { return (folder() / name).string(); }

  void SetUp() override {
    const auto even = [&](const char* name, double value) {
      const std::vector<float> values(block.cells(), static_cast<float>(value));
      io::write_npy(at(name), {24, 40, 40}, std::span<const float>(values));
    };
    even("kappa.npy", kappa);
    even("mu.npy", mua);
    SurfaceMeasurements m;
    m.grid = block;
    m.eta = 1.4;
    m.seen_face = Face::z_minus;
    m.channels = {"grey"};
    m.patterns = static_cast<int>(phases);
    for (std::size_t p = 0; p < phases; ++p) {
      for (std::size_t i = 0; i < m.lit_shape().cells(); ++i) {
        const double x = (static_cast<double>(i % 40) + 0.5) * block.voxel_mm;
        const double cycles = 0.2 * x + static_cast<double>(p) / phases;
        m.irradiance.push_back(
            static_cast<float>(0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * cycles)));
      }
    }
    io::write_npy(at("light.npy"), {phases, 40, 40}, std::span<const float>(m.irradiance));
    const ProcessResult made =
        kappamu("forward --kappa " + at("kappa.npy") + " --mu " + at("mu.npy") +
                " --voxel 0.5 --eta 1.4 --irradiance " + at("light.npy") +
                " --method montecarlo --anisotropy 0.9 --photons 200000 -o " + at("light"));
    ASSERT_EQ(made.exit_code, 0) << made.standard_error;
    m.value = io::read_npy(at("light/exitance_z-.npy")).values;
    const std::vector<float> error = io::read_npy(at("light/standard_error_z-.npy")).values;
    for (std::size_t i = 0; i < error.size(); ++i) {
      const float instrument = 1e-3F * m.value[i];
      m.variance.push_back(error[i] * error[i] + instrument * instrument);
    }
    m.mask.assign(m.value.size(), 0);
    m.lit.assign(m.value.size(), 1);
    fs::create_directories(at("measured"));
    io::write_measurements(at("measured"), m);
  }
};

TEST_F(LitPixelsFit, FindsTheBlockThatMonteCarloLit) {
  const ProcessResult fitted = kappamu("fit " + at("measured") + " -o " + at("fit"));
  ASSERT_EQ(fitted.exit_code, 0) << fitted.standard_error;
  constexpr double within = 0.06;  // measured: κ 3.9 % and μ 3.7 % too high
  EXPECT_NEAR(io::read_npy(at("fit/kappa_grey.npy")).values.front() / kappa, 1.0, within);
  EXPECT_NEAR(io::read_npy(at("fit/mu_grey.npy")).values.front() / mua, 1.0, within);
  const auto record = nlohmann::json::parse(io::read_text(at("fit/fit.json")));
  EXPECT_TRUE(record.at("lit_pixels").get<bool>());
  EXPECT_THAT(record.at("channels").at(0).at("notes").at(0).get<std::string>(),
              testing::HasSubstr("Lit pixels are used under slowly varying light"));
  expect_one_sentence(kappamu("fit " + at("measured") + " --model volume -o " + at("none")),
                      "every pixel of the seen face is lit, and lit pixels cannot be used: "
                      "diffusion does not describe them");
}

}  // namespace
}  // namespace kappamu::app
