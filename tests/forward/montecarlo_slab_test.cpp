// Monte Carlo transport against published slab and half-space values.
#include "tests/forward/montecarlo_test_tools.h"

namespace kappamu::forward {
namespace {

using testing::Slab;
using testing::trace_slab;
class MonteCarloSlab : public testing::WithDevice {};

TEST_F(MonteCarloSlab, AgreesWithVanDeHulstAnisotropic) {
  // van de Hulst 1980, table 35, as quoted by Wang, Jacques, Zheng 1995 (MCML): albedo 0.9, optical
  // thickness 2, g = 0.75, matched index: R_d = 0.09739, T_t = 0.66096, unscattered light in it.
  const auto light = trace_slab(context(), {10.0, 90.0, 0.75, 0.02, 1.0}, 1'000'000, 1);
  EXPECT_NEAR(light.reflected, 0.09739, 3.0 * light.reflected_error);
  const double transmitted = light.transmitted + light.unscattered;
  EXPECT_NEAR(transmitted, 0.66096, 3.0 * std::hypot(light.transmitted_error, 0.0005));
         light.transmitted_error);
}

}  // namespace
}  // namespace kappamu::forward
