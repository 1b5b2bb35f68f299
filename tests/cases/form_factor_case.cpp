#include "tests/cases/form_factor_case.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/random.h"

namespace kappamu::test_cases {

FormFactorCase form_factor_case(std::uint64_t seed, std::uint64_t number) {
  std::uint64_t drawn = 0;
  const auto u = [&] { return uniform(key_of({seed, number, drawn++})); };
  const auto spread = [&](double low, double high) { return low * std::pow(high / low, u()); };
  FormFactorCase c;
  c.material.kappa = spread(0.05, 1.0);
  c.material.mu = spread(1e-5, 0.3) / (3.0 * c.material.kappa);
  const double mean_free_path = 3.0 * c.material.kappa, size = mean_free_path * spread(0.1, 30.0);
  for (Eigen::Vector3d& v : c.triangle) v = size * (Eigen::Vector3d(u(), u(), u()).array() - 0.5);
  const auto& [a, b, d] = c.triangle;
  const Eigen::Vector3d normal = (b - a).cross(d - a).normalized();
  const double x = u(), y = u();
  c.point = a * x + b * y + d * (1.0 - x - y);
  const double height = mean_free_path * spread(0.05, 10.0);
  if (number % 3 != 0) c.point += normal * (u() < 0.5 ? -height : height);
  c.on_edge = number % 5 == 0;
  if (c.on_edge) c.point = 0.3 * a + 0.7 * b;
  return c;
}

}  // namespace kappamu::test_cases
