// Monte Carlo behind the interface of forward models: units, shapes, errors, and what it refuses.
#include "forward/forward_model.h"
#include "tests/forward/montecarlo/test_tools.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

class MonteCarloModel : public testing::WithDevice {
 protected:
  static ForwardProblem problem() {
    ForwardProblem p;
    p.setup.shape = {5, 4, 3, 0.5};
    p.medium = testing::homogeneous(p.setup.shape, 0.1, 2.0);
    p.patterns = 2;
    p.irradiance.assign(2 * 20, 0.0);
    p.irradiance[7] = 1.0;
    for (std::size_t k = 20; k < 40; ++k) p.irradiance[k] = 2.0;
    return p;
  }
  static ForwardResult solve(const ForwardProblem& p, std::uint64_t photons = 20'000) {
    ForwardOptions options;
    options.photons = photons;
    Progress silent;
    return make_forward_model("montecarlo")->solve(p, options, silent);
  }
};

TEST_F(MonteCarloModel, MapsAreExitancePerAreaAndBalanceTheirLight) {
  const ForwardProblem p = problem();
  const ForwardResult result = solve(p);
  const double area = 0.25;
  const double transmittance = boundary_constants(1.3).normal_transmittance;
  EXPECT_NEAR(result.balance[0].entering, transmittance * area, 1e-12);
  EXPECT_NEAR(result.balance[1].entering, transmittance * area * 40.0, 1e-12);
  for (std::size_t m = 0; m < 2; ++m) {
    const PowerBalance& balance = result.balance[m];
    double leaving = balance.absorbed + balance.unscattered;
    for (std::size_t f = 0; f < 6; ++f) {
      const std::size_t pixels = face_shape(p.setup.shape, all_faces[f]).cells();
      ASSERT_EQ(result.exitance[f].size(), 2 * pixels);
      ASSERT_EQ(result.standard_error[f].size(), 2 * pixels);
      double sum = 0.0;
      for (std::size_t k = 0; k < pixels; ++k) sum += result.exitance[f][m * pixels + k] * area;
      EXPECT_NEAR(sum, balance.exiting[f], 1e-12 * balance.entering);
      leaving += balance.exiting[f];
    }
    EXPECT_NEAR(leaving, balance.entering, 1e-12 * balance.entering);
  }
}

TEST_F(MonteCarloModel, LightIsLinearInIrradiance) {
  ForwardProblem p = problem();
  const ForwardResult one = solve(p);
  for (double& e : p.irradiance) e *= 8.0;
  const ForwardResult eight = solve(p);
  for (std::size_t f = 0; f < 6; ++f) {
    for (std::size_t k = 0; k < one.exitance[f].size(); ++k) {
      EXPECT_DOUBLE_EQ(eight.exitance[f][k], 8.0 * one.exitance[f][k]);
      EXPECT_DOUBLE_EQ(eight.standard_error[f][k], 8.0 * one.standard_error[f][k]);
    }
  }
}

TEST_F(MonteCarloModel, AMeanOverPixelsHasTheErrorOfItsPhotons) {
  const ForwardProblem p = problem();
  const ForwardResult result = solve(p);
  const std::size_t pixels = 20;
  const std::span<const double> map(result.exitance[5]), error(result.standard_error[5]);
  const double whole = standard_error_of_mean(map.subspan(pixels), error.subspan(pixels),
                                              result.balance[1].entering, 0.25, 20'000);
  // Photons of nearly full weight leave with chance c: √(c(1−c)/N).
  const double power = result.balance[1].exiting[5], c = power / result.balance[1].entering;
  const double binomial =
      result.balance[1].entering * std::sqrt(c * (1.0 - c) / 20'000) / (pixels * 0.25);
  EXPECT_LT(whole, binomial);
  EXPECT_GT(whole, 0.7 * binomial);
  double independent = 0.0;
  for (std::size_t k = pixels; k < 2 * pixels; ++k) independent += error[k] * error[k];
  EXPECT_LT(whole, std::sqrt(independent) / pixels);
}

TEST_F(MonteCarloModel, PixelsNobodyReachedHaveTheErrorOfOnePhoton) {
  const ForwardProblem p = problem();
  const ForwardResult result = solve(p, 20);
  bool dark = false;
  for (std::size_t k = 0; k < 20; ++k) {
    if (result.exitance[5][k] > 0.0) continue;
    dark = true;
    EXPECT_DOUBLE_EQ(result.standard_error[5][k], result.balance[0].entering / 0.25 / 20.0);
  }
  EXPECT_TRUE(dark);
}

TEST_F(MonteCarloModel, RefusesWhatIsNoTransport) {
  ForwardProblem p = problem();
  for (const std::uint64_t photons : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1} << 32}) {
    EXPECT_NE(sentence_of([&] { solve(p, photons); }).find("photons"), std::string::npos);
  }
  p.medium.mu[3] = 10.0;
  EXPECT_NE(sentence_of([&] { solve(p); }).find("(3, 0, 0)"), std::string::npos);
  p = problem();
  p.setup.convention = Convention::wang2008;
  p.setup.source = SourceModel::boundary;
  EXPECT_NE(sentence_of([&] { solve(p); }).find("convention"), std::string::npos);
}

}  // namespace
}  // namespace kappamu::forward
