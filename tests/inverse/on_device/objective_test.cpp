// An objective whose medium, light, data and gradients are in the memory of a device: the host's to
// the solver's tolerance.
#include "inverse/problem/objective.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/numbers/relative_difference.h"
#include "device/device_info.h"
#include "inverse/kernels/device_arithmetic.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

std::vector<double> joined(const CoefficientPair& fields) {
  std::vector<double> both = fields.log_kappa;
  both.insert(both.end(), fields.log_mu.begin(), fields.log_mu.end());
  return both;
}

struct Kind {
  const char* name;
  GridShape shape;
  forward::SourceModel source = forward::SourceModel::first_collision;
  bool two_faces = false;
  SmoothError shared{};
  DataTermOptions term{};
};

/// More patterns than are solved at once, some data masked.
Problem problem_of(const Kind& kind) {
  cases::Noise noise(3);
  Problem problem = cases::randomly_lit(kind.shape, 11, noise);
  problem.setup.source = kind.source;
  if (kind.two_faces) {
    problem.seen_face = Face::z_minus;
    for (int m = 0; m < problem.patterns; ++m) {
      problem.seen_faces.push_back(m % 3 == 0 ? Face::z_minus : Face::z_plus);
    }
  }
  const std::size_t pixels = problem.seen_shape().cells();
  for (std::size_t i = 0; i < 11 * pixels; ++i) {
    problem.data.push_back(0.1 * noise.uniform());
    problem.weight.push_back(i % 7 == 0 ? 0.0 : 1.0 + noise.uniform());
  }
  problem.smooth_error = kind.shared;
  if (!kind.shared.none()) {
    problem.precision.emplace(problem.seen_shape(), problem.patterns, 10.0, kind.shared);
  }
  return problem;
}

class ObjectiveOnDevice : public ::testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    const std::vector<device::DeviceInfo> devices = device::list_devices();
    if (devices.empty()) GTEST_SKIP() << "no OpenCL device is installed";
    const std::size_t index = device::choose(devices, "auto").index;
    if (!devices[index].fp64) GTEST_SKIP() << "the device has no double precision";
    context_ = &device::Context::of(index);
  }
  static Objective objective(VectorPlace place) {
    Backend backend{"auto", forward::Precision::double_precision, {1e-12, 300}, 4};
    backend.refined_tolerance = 1e-12;
    backend.vectors = place;
    return {problem_of(GetParam()), backend, GetParam().term};
  }

  device::Context* context_ = nullptr;
};

TEST_P(ObjectiveOnDevice, HasTheHostsValuesAndDerivatives) {
  Objective host = objective(VectorPlace::host), there = objective(VectorPlace::device);
  const CoefficientPair fields = cases::rough_medium(GetParam().shape, 0.2, 5);
  const auto alike = [&] {
    EXPECT_LT(relative_difference(joined(there.gradient()), joined(host.gradient())), 1e-8);
    EXPECT_LT(relative_difference(there.prediction(), host.prediction()), 1e-9);
    EXPECT_LT(relative_difference(there.root_weight(), host.root_weight()), 1e-9);
    EXPECT_NEAR(there.chi2_per_value(), host.chi2_per_value(), 1e-9 * host.chi2_per_value());
  };
  const double value = host.value(fields);
  EXPECT_NEAR(there.value(fields), value, 1e-9 * value);
  alike();
  std::vector<double> probe(host.problem().data.size());
  for (std::size_t i = 0; i < probe.size(); ++i) probe[i] = i % 3 == 0 ? 1.0 : -1.0;
  EXPECT_LT(relative_difference(joined(there.jacobian_transpose(probe)),
                                joined(host.jacobian_transpose(probe))),
            1e-8);
  const CoefficientPair direction = cases::random_direction(GetParam().shape, 6);
  EXPECT_LT(relative_difference(there.jacobian(direction), host.jacobian(direction)), 1e-8);

  const double renewed = host.refresh_correction(refine(host.problem()), fields);
  EXPECT_NE(renewed, value);
  EXPECT_NEAR(there.refresh_correction(refine(there.problem()), fields), renewed, 1e-8 * renewed);
  EXPECT_LT(relative_difference(there.correction().ratio, host.correction().ratio), 1e-9);
  alike();
}

TEST_P(ObjectiveOnDevice, TakesFieldsThatAreThere) {
  Objective host = objective(VectorPlace::host), there = objective(VectorPlace::device);
  DeviceArithmetic arithmetic(*context_);
  const std::size_t cells = GetParam().shape.cells();
  const device::Buffer gradient = arithmetic.take(2 * cells);
  // The second with another r: the device's copy is renewed.
  for (const double contrast : {0.2, 0.1}) {
    const CoefficientPair fields = cases::rough_medium(GetParam().shape, contrast, 5);
    const double value = host.value(fields);
    EXPECT_NEAR(there.value(arithmetic.upload(fields), {3.0, {}}), value, 1e-9 * value);
    EXPECT_NEAR(there.chi2_per_value(), host.chi2_per_value(), 1e-9 * host.chi2_per_value());
    there.gradient(gradient);
    const std::vector<double> expected = joined(host.gradient());
    EXPECT_LT(relative_difference(joined(arithmetic.download(gradient, cells)), expected), 1e-8);

    const int solves = there.solves().forward;
    there.came_from(fields);
    EXPECT_NEAR(there.value(fields), value, 1e-9 * value);
    EXPECT_EQ(there.solves().forward, solves) << "solved already";
    EXPECT_LT(relative_difference(there.prediction(), host.prediction()), 1e-9);
    EXPECT_LT(relative_difference(joined(there.gradient()), expected), 1e-8);
    host.refresh_correction(refine(host.problem()), fields);
    there.refresh_correction(refine(there.problem()), fields);
  }
  EXPECT_EQ(there.value(arithmetic.upload(cases::rough_medium(GetParam().shape, 0.1, 5)),
                        {max_log_coefficient + 1.0, {}}),
            HUGE_VAL);
}

INSTANTIATE_TEST_SUITE_P(
    Of, ObjectiveOnDevice,
    ::testing::Values(Kind{"Plain", {9, 7, 5, 0.4}}, Kind{"OneVoxelDeep", {6, 9, 1, 0.4}},
                      Kind{"DiffuseLight", {7, 8, 4, 0.4}, forward::SourceModel::boundary},
                      Kind{"TwoFaces", {7, 5, 4, 0.4}, forward::SourceModel::boundary, true},
                      Kind{"SharedErrors",
                           {8, 6, 4, 0.4},
                           forward::SourceModel::first_collision,
                           false,
                           {0.1, 0.2}},
                      Kind{"Robust",
                           {8, 6, 4, 0.4},
                           forward::SourceModel::first_collision,
                           false,
                           {},
                           {Loss::huber}}),
    [](const auto& kind) { return std::string(kind.param.name); });

}  // namespace
}  // namespace kappamu::inverse
