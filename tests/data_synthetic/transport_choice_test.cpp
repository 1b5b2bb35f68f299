// The simulator's two lights through one block: Monte Carlo is reproducible, fresh at every call,
// and tells of the same block as diffusion.
#include <gtest/gtest.h>

#include <numeric>

#include "data_synthetic/scene/materials.h"
#include "data_synthetic/transport.h"
#include "device/device_info.h"
#include "tests/sentence.h"

namespace kappamu::synthetic {
namespace {

const SampleModel& tiny_sample() {
  static const SampleModel sample = make_sample("tiny", 1);
  return sample;
}

std::vector<double> even_light() {
  return std::vector<double>(face_shape(tiny_sample().grid, Face::z_minus).cells(), 1.0);
}

std::vector<double> exitance_of(TransportMethod method, std::uint64_t seed) {
  Transport transport({.shape = tiny_sample().grid}, "auto",
                      {.method = method, .photons = 40'000, .seed = seed});
  transport.set_medium(sample_medium(tiny_sample(), tiny_sample().grid)[0]);
  return transport.exitance(even_light(), Face::z_plus);
}

TEST(TransportChoice, MonteCarloIsReproducibleAndFreshAtEveryCall) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  const auto first = exitance_of(TransportMethod::monte_carlo, 7);
  EXPECT_EQ(exitance_of(TransportMethod::monte_carlo, 7), first);
  EXPECT_NE(exitance_of(TransportMethod::monte_carlo, 8), first);

  Transport transport({.shape = tiny_sample().grid}, "auto",
                      {.method = TransportMethod::monte_carlo, .photons = 40'000, .seed = 7});
  transport.set_medium(sample_medium(tiny_sample(), tiny_sample().grid)[0]);
  EXPECT_EQ(transport.exitance(even_light(), Face::z_plus), first);
  EXPECT_NE(transport.exitance(even_light(), Face::z_plus), first);
}

TEST(TransportChoice, BothTellOfTheSameBlock) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  const auto diffusion = exitance_of(TransportMethod::diffusion, 1);
  const auto monte_carlo = exitance_of(TransportMethod::monte_carlo, 1);
  const auto total = [](const std::vector<double>& map) {
    return std::accumulate(map.begin(), map.end(), 0.0);
  };
  // The sample is a few mean free paths thick and its voxels coarse: diffusion's own error.
  constexpr double diffusion_error = 0.1;
  EXPECT_NEAR(total(monte_carlo), total(diffusion), diffusion_error * total(diffusion));
}

TEST(TransportChoice, ReportsNameThePhysics) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  const Transport diffusion({.shape = tiny_sample().grid}, "reference");
  EXPECT_EQ(diffusion.model(), "grid diffusion, physical convention, first-collision source");
  const Transport monte_carlo({.shape = tiny_sample().grid}, "auto",
                              {.method = TransportMethod::monte_carlo, .photons = 1234, .seed = 1});
  EXPECT_NE(monte_carlo.model().find("Monte Carlo"), std::string::npos);
  EXPECT_NE(monte_carlo.model().find("1234 photons"), std::string::npos);
}

TEST(TransportChoice, MonteCarloHasNoSerialReference) {
  Transport transport({.shape = tiny_sample().grid}, "reference",
                      {.method = TransportMethod::monte_carlo, .photons = 1000, .seed = 1});
  transport.set_medium(sample_medium(tiny_sample(), tiny_sample().grid)[0]);
  const std::string sentence =
      sentence_of([&] { (void)transport.exitance(even_light(), Face::z_plus); });
  EXPECT_NE(sentence.find("no serial reference"), std::string::npos) << sentence;
}

}  // namespace
}  // namespace kappamu::synthetic
