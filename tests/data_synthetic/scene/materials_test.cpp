// Laws of the simulated samples. That light passes through them is tested in simulated_rig_test.
#include "data_synthetic/scene/materials.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/sentence.h"

namespace kappamu::synthetic {
namespace {

TEST(Materials, AreTheSamplesOfThePaperInSizeAndSetup) {
  const auto expect_size = [](const std::string& name, int nx, int ny, int nz,
                              capture::Setup setup) {
    const SampleModel sample = make_sample(name, 1);
    EXPECT_EQ(sample.grid.nx, nx) << name;
    EXPECT_EQ(sample.grid.ny, ny) << name;
    EXPECT_EQ(sample.grid.nz, nz) << name;
    EXPECT_EQ(sample.setup, setup) << name;
    EXPECT_DOUBLE_EQ(sample.eta, 1.3) << name;
  };
  expect_size("wax1", 130, 53, 37, capture::Setup::back_lit);
  expect_size("wax2", 140, 75, 48, capture::Setup::front_lit);
  expect_size("marble", 256, 256, 20, capture::Setup::back_lit);
  expect_size("stone", 128, 128, 41, capture::Setup::back_lit);
}

TEST(Materials, StayWithinPublishedRangesWithAContrastOfAFew) {
  for (const std::string& name : sample_names()) {
    const SampleModel sample = make_sample(name, 3);
    const GridShape coarse{16, 12, 8, sample.grid.nx * sample.grid.voxel_mm / 16};
    const std::array<Medium, 3> media = sample_medium(sample, coarse);
    for (const Medium& medium : media) {
      validate(medium, name);
      for (std::size_t i = 0; i < coarse.cells(); ++i) {
        const double total = 1.0 / (3.0 * medium.kappa[i]);
        const double scattering = total - medium.mu[i];
        // Reduced scattering of translucent solids: 0.5 to 6 per mm; absorption up to 0.2 per mm.
        EXPECT_GT(scattering, 0.4) << name;
        EXPECT_LT(scattering, 7.0) << name;
        EXPECT_GT(medium.mu[i], 5e-4) << name;
        EXPECT_LT(medium.mu[i], 0.25) << name;
        EXPECT_LT(medium.mu[i], 0.3 * scattering) << name << ": diffusion would fail";
      }
      const auto [low, high] =
          std::minmax_element(medium.mu.values().begin(), medium.mu.values().end());
      EXPECT_GT(*high / *low, name == "phantom" ? 0.999 : 1.5) << name;
    }
  }
}

TEST(Materials, AreAFunctionOfSeedAndPlaceAlone) {
  const SampleModel first = make_sample("marble", 5);
  const SampleModel again = make_sample("marble", 5);
  const SampleModel other = make_sample("marble", 6);
  double difference = 0.0;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d x(2.4 * i, 60.0 - i, 0.19 * i);
    EXPECT_EQ(first.coefficients(x).absorption, again.coefficients(x).absorption);
    difference +=
        std::abs(first.coefficients(x).absorption[0] / other.coefficients(x).absorption[0] - 1.0);
  }
  EXPECT_GT(difference, 1.0);
}

TEST(Materials, AreContinuous) {
  constexpr double step_mm = 1e-4;
  // The steepest ramp: a factor of 7 over two thirds of a voxel pair; well below 20 per mm.
  constexpr double steepest_per_mm = 20.0;
  for (const std::string& name : sample_names()) {
    const SampleModel sample = make_sample(name, 1);
    for (int i = 0; i < 400; ++i) {
      const Eigen::Vector3d x = Eigen::Vector3d(std::fmod(0.37 * i, 1.0) * sample.grid.nx,
                                                std::fmod(0.61 * i, 1.0) * sample.grid.ny,
                                                std::fmod(0.83 * i, 1.0) * sample.grid.nz) *
                                sample.grid.voxel_mm;
      const PointCoefficients here = sample.coefficients(x);
      const PointCoefficients there = sample.coefficients(x + Eigen::Vector3d::Constant(step_mm));
      for (int c = 0; c < 3; ++c) {
        EXPECT_LT(std::abs(std::log(here.absorption[c] / there.absorption[c])),
                  steepest_per_mm * step_mm * std::sqrt(3.0))
            << name;
      }
    }
  }
}

TEST(Materials, NamesTheSamplesWhenAskedForAnother) {
  const std::string sentence = sentence_of([&] { make_sample("granite", 1); });
  EXPECT_THAT(sentence,
              testing::AllOf(testing::HasSubstr("granite"), testing::HasSubstr("marble, stone")));
}

}  // namespace
}  // namespace kappamu::synthetic
