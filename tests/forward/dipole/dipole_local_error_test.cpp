// What local diffusion states of its own error, on shapes and lights that none of its settings was
// chosen on: against the full integral by quadrature.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/shapes.h"
#include "forward/dipole/direct/direct_sum.h"
#include "forward/dipole/transmitted.h"
#include "forward/registry.h"
#include "tests/forward/lit_object.h"

namespace kappamu::forward::dipole {
namespace {

using testing::HasSubstr;

struct View {
  const char* name;
  TriangleMesh (*mesh)();
  Coefficients medium;
  Eigen::Vector3d light;  ///< of travel; zero: even from above
  Eigen::Vector3d eye;
  bool in_image_space;
};

TriangleMesh stretched(const char* shape, int tessellation, const Eigen::Vector3d& edges,
                       std::optional<double> proportion = {}) {
  TriangleMesh mesh = make_shape(shape, 1.0, tessellation, proportion);
  for (Eigen::Vector3d& v : mesh.vertices) v = v.cwiseProduct(edges);
  return mesh;
}
TriangleMesh egg() {
  return stretched("sphere", 14, {50.0, 30.0, 40.0});
}
TriangleMesh cone() {
  return stretched("spike", 20, {60.0, 60.0, 60.0}, 0.7);
}
TriangleMesh ring() {
  return stretched("torus", 16, {70.0, 50.0, 60.0}, 0.5);
}
TriangleMesh drum() {
  return stretched("cylinder", 14, {40.0, 40.0, 40.0}, 0.9);
}
TriangleMesh wafer() {
  return stretched("slab", 12, {30.0, 30.0, 30.0}, 0.12);
}

void PrintTo(const View& view, std::ostream* to) {
  *to << view.name;
}

class StatedError : public testing::TestWithParam<View> {};

TEST_P(StatedError, IsThatOfTheFullIntegral) {
  const View& view = GetParam();
  LitObject object(view.mesh(), ObjectMedium(view.medium));
  object.lights = {view.light.isZero() ? sky(object.surface)
                                       : parallel_beams(object.surface, view.light.normalized())};
  const ObjectProblem problem = object.problem();
  ObjectOptions options;
  options.tolerance = 0.08;
  options.eye = view.eye;
  Progress silent;
  const ObjectResult result = make_object_model("local-diffusion")->solve(problem, options, silent);
  EXPECT_THAT(result.message, HasSubstr(view.in_image_space ? "integrated in image space"
                                                            : "over the surface, not in image"));
  EXPECT_THAT(result.message, HasSubstr(" % of the full integral"));

  const Profile profile = make_profile("dipole", {view.medium.kappa, view.medium.mu}, problem.eta);
  const std::vector<double> irradiance = transmitted(object.surface, problem.eta, object.lights[0]);
  constexpr std::size_t one_of = 5;
  std::vector<std::size_t> some;
  for (std::size_t t = 0; t < object.surface.size(); t += one_of) some.push_back(t);
  const std::vector<double> exact =
      direct_sum(object.mesh, object.surface, profile, Placement::rotated, irradiance, some);
  double squares = 0.0, size = 0.0;
  for (std::size_t i = 0; i < some.size(); ++i) {
    const double area = object.surface.area[some[i]];
    squares += area * std::pow(result.exitance[some[i]] - exact[i], 2);
    size += area * exact[i] * exact[i];
  }
  const double error = std::sqrt(squares / size);
  // Rare bright samples, which few samples a triangle miss: nine views lie within the stated error,
  // the cone exceeds it by a fifth.
  constexpr double heavy_tails = 1.25;
  EXPECT_LE(error, heavy_tails * result.error_estimate[0]) << result.message;
  EXPECT_GE(error, 0.2 * result.error_estimate[0]) << result.message;
  EXPECT_EQ(result.converged, result.error_estimate[0] <= options.tolerance);
  RecordProperty("true_over_stated", std::to_string(error / result.error_estimate[0]));
}

const Coefficients dull{1.0 / 3.0, 0.1}, clear{1.0 / 3.0, 0.001};  // a mean free path of 1 mm
const Eigen::Vector3d even = Eigen::Vector3d::Zero();

INSTANTIATE_TEST_SUITE_P(
    Views, StatedError,
    testing::Values(View{"egg", egg, dull, {0.0, 0.0, -1.0}, {40.0, 10.0, 300.0}, true},
                    View{"egg, aslant", egg, dull, {-1.0, 0.0, -1.0}, {0.0, -200.0, 200.0}, false},
                    View{"egg, even", egg, dull, even, {200.0, 100.0, 200.0}, false},
                    View{"egg, clear", egg, clear, {0.0, 0.0, -1.0}, {0.0, 0.0, -300.0}, false},
                    View{"cone", cone, dull, {-1.0, 0.3, -0.4}, {250.0, 0.0, 100.0}, true},
                    View{"cone, clear", cone, clear, {1.0, 0.0, 0.0}, {250.0, 0.0, 0.0}, false},
                    View{"ring", ring, dull, {0.1, 0.2, -1.0}, {30.0, 60.0, 300.0}, true},
                    View{"ring, even", ring, dull, even, {10.0, -150.0, 250.0}, true},
                    View{"drum", drum, dull, {-1.0, -1.0, -2.0}, {150.0, 150.0, 250.0}, true},
                    View{"wafer", wafer, clear, {0.0, 0.0, 1.0}, {0.0, 0.0, 200.0}, false}));

}  // namespace
}  // namespace kappamu::forward::dipole
