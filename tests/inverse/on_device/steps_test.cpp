// A fit's vectors in the memory of a device: coordinates, function, gradient and steps are the
// host's to rounding.
#include "inverse/on_device/steps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "core/numbers/relative_difference.h"
#include "inverse/on_device/device_basis.h"
#include "inverse/on_device/device_function.h"
#include "inverse/optimise/lateral_hessian.h"
#include "inverse/problem/problem.h"
#include "tests/inverse/fit/fit_cases.h"

namespace kappamu::inverse {
namespace {

class OnDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::vector<device::DeviceInfo> devices = device::list_devices();
    if (devices.empty()) GTEST_SKIP() << "no OpenCL device is installed";
    const std::size_t index = device::choose(devices, "auto").index;
    if (!devices[index].fp64) GTEST_SKIP() << "the device has no double precision";
    arithmetic_.emplace(device::Context::of(index));
  }
  device::Buffer upload(const Vector& values) {
    const device::Buffer buffer = arithmetic_->take(values.size());
    arithmetic_->context().write(buffer, values.data(), values.size() * sizeof(double));
    return buffer;
  }
  Vector read(const device::Buffer& buffer, std::size_t size) {
    return arithmetic_->read(buffer, size);
  }

  std::optional<DeviceArithmetic> arithmetic_;
};

Vector joined(const CoefficientPair& fields) {
  Vector both = fields.log_kappa;
  both.insert(both.end(), fields.log_mu.begin(), fields.log_mu.end());
  return both;
}

LateralBlocks random_blocks(const MediumSpace& space) {
  const LateralModes modes(space);
  cases::Noise noise(3);
  LateralBlocks blocks;
  for (int bin = 0; bin < modes.bins(); ++bin) {
    Eigen::MatrixXd m(modes.rows(), modes.rows());
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = noise.normal();
    blocks.emplace_back(m * m.transpose() + Eigen::MatrixXd::Identity(modes.rows(), modes.rows()));
  }
  return blocks;
}

TEST_F(OnDevice, CoordinatesAreThoseOfTheHostAlongEveryDepthAxis) {
  // More values along an axis than a tile has, fewer, and one.
  for (const GridShape& shape :
       {GridShape{70, 5, 3, 0.3}, GridShape{4, 66, 17, 0.3}, GridShape{1, 9, 6, 0.3}}) {
    for (const int axis : {0, 1, 2}) {
      const MediumSpace space{shape, axis, 1.2};
      const Basis basis(space, {Coordinates::informed, 1.2, 10.0}, random_blocks(space));
      DeviceBasis on_device(*arithmetic_, space, basis);
      const CoefficientPair u = cases::random_direction(shape, 1);
      const Vector z = joined(cases::random_direction(shape, 2));
      const device::Buffer result = arithmetic_->take(z.size());
      on_device.gradient(upload(joined(u)), result);
      EXPECT_LT(relative_difference(read(result, z.size()), basis.gradient(u)), 1e-12);
      on_device.to_fields(upload(z), result);
      EXPECT_LT(relative_difference(read(result, z.size()), joined(basis.to_fields(z))), 1e-12);
    }
  }
}

/// The function of one weight, its objective to the last digit.
struct Fitted {
  test_cases::Block block;
  Objective objective;
  LateralBlocks blocks;
  Basis basis;
  CoefficientPair start;
  FitFunction function;

  Fitted(const Regulariser& regulariser, const AbsorptionScale& scale)
      : block(small()),
        objective(
            make_problem(cases::measure(block, cases::smooth_medium(block.grid.refined(2)), 2), 0,
                         forward::Convention::physical, {0.001, 5e-5}),
            exact()),
        blocks(blocks_at(objective, cases::rough_medium(block.grid, 0.1, 3))),
        basis(objective.space(), {Coordinates::informed, 2.5, 300.0}, blocks),
        start(cases::rough_medium(block.grid, 0.2, 4)),
        function(objective, basis, {std::log(0.15), std::log(0.05), 25.0}, 30.0, regulariser, start,
                 scale) {}

  static test_cases::Block small() {
    test_cases::Block block;
    block.grid = {9, 7, 5, 0.5};
    return block;
  }
  static Backend exact() {
    Backend backend;
    backend.precision = forward::Precision::double_precision;
    backend.solve.tolerance = 1e-12;
    return backend;
  }
  static LateralBlocks blocks_at(Objective& objective, const CoefficientPair& fields) {
    objective.value(fields);
    return lateral_blocks(random_rows(objective, 2, 1), objective.space());
  }
  Steps steps(OptimiserState& state, VectorPlace place) {
    return {objective, basis, function, state, {}, place};
  }
};

struct Kind {
  const char* name;
  Regulariser regulariser;
  AbsorptionScale scale{};
  bool slopes = false;
};

class DeviceSteps : public OnDevice, public ::testing::WithParamInterface<Kind> {};

TEST_P(DeviceSteps, ValueAndGradientAreTheHosts) {
  Fitted fit(GetParam().regulariser, GetParam().scale);
  if (GetParam().slopes) {
    Correction r = fit.objective.correction();
    r.variance.assign(r.ratio.size(), 1e-6);
    r.pixel_variance = r.variance;
    r.slope[0].assign(r.ratio.size(), 0.3);
    r.slope[1].assign(r.ratio.size(), -0.2);
    r.mean = {std::log(0.2), std::log(0.03)};
    fit.objective.set_correction(r);
  }
  Vector z = fit.function.coordinates(fit.start);
  cases::Noise noise(9);
  for (double& x : z) x += 0.05 * noise.normal();
  const double value = fit.function.value(z);
  const double roughness = fit.function.last_roughness();
  const Vector gradient = fit.function.gradient();
  DeviceFunction function(*arithmetic_, fit.objective, fit.basis,
                          {fit.function.anchor(), fit.function.weight(), fit.function.regulariser(),
                           fit.function.scale()});
  const device::Buffer fields = arithmetic_->take(z.size()), by_z = arithmetic_->take(z.size());
  function.to_fields(upload(z), fields);
  EXPECT_LT(relative_difference(read(fields, z.size()), joined(fit.function.fields(z))), 1e-12);
  EXPECT_NEAR(function.value(fields), value, 1e-9 * value);
  EXPECT_NEAR(function.roughness(), roughness, 1e-12 * roughness);
  function.gradient(fields, by_z);
  EXPECT_LT(relative_difference(read(by_z, z.size()), gradient), 1e-8);
}

TEST_P(DeviceSteps, StepsAreTheHostsUntilRoundingParts) {
  Fitted fit(GetParam().regulariser, GetParam().scale);
  OptimiserState by_host;
  by_host.z = fit.function.coordinates(fit.start);
  start(fit.function, by_host);
  OptimiserState by_device = by_host;
  constexpr int count = 15;  // more than the pairs that are kept
  Steps host = fit.steps(by_host, VectorPlace::host);
  for (int k = 0; k < count; ++k) ASSERT_EQ(host.step(), StepOutcome::progressed);
  const CoefficientPair expected = host.fields();
  Steps device = fit.steps(by_device, VectorPlace::device);
  ASSERT_TRUE(device.on_device());
  EXPECT_FALSE(fit.steps(by_device, VectorPlace::automatic).on_device()) << "of a processor";
  const double begun = by_device.value;
  for (int k = 0; k < count; ++k) ASSERT_EQ(device.step(), StepOutcome::progressed);
  EXPECT_LT(by_host.value, 0.1 * begun);
  EXPECT_NEAR(by_device.value, by_host.value, 1e-5 * by_host.value);
  EXPECT_LT(relative_difference(device.fields().log_kappa, expected.log_kappa), 1e-4);

  const int solves = fit.objective.solves().forward;
  device.store();
  device.leave();
  EXPECT_EQ(by_device.steps.size(), by_host.steps.size());
  EXPECT_LT(relative_difference(by_device.z, by_host.z), 1e-3);
  // The host finds what the device has solved.
  EXPECT_NEAR(fit.function.value(by_device.z), by_device.value, 1e-9 * by_device.value);
  EXPECT_EQ(fit.objective.solves().forward, solves);
  EXPECT_LT(relative_difference(fit.function.gradient(), by_device.gradient), 1e-7);
}

/// A fit's next weight begins where the last one stands, with its pairs.
TEST_P(DeviceSteps, PairsGoOnToTheNextWeightAsTheHosts) {
  Fitted fit(GetParam().regulariser, GetParam().scale);
  OptimiserState state;
  state.z = fit.function.coordinates(fit.start);
  start(fit.function, state);
  Steps device = fit.steps(state, VectorPlace::device);
  for (int k = 0; k < 4; ++k) ASSERT_EQ(device.step(), StepOutcome::progressed);
  device.store();
  device.leave();
  const CoefficientPair here = device.fields();

  const Basis basis(fit.objective.space(), {Coordinates::informed, 2.5, 90.0},
                    Fitted::blocks_at(fit.objective, here));
  FitFunction next(fit.objective, basis, fit.function.anchor(), 9.0, fit.function.regulariser(),
                   here, fit.function.scale());
  OptimiserState by_host = state, by_device;
  by_host.z = by_device.z = next.coordinates(here);
  restart(next, by_host,
          [&](Vector& step, Vector& change) { next.adopt(fit.function, step, change); });
  start(next, by_device);
  Steps there(fit.objective, basis, next, by_device, {}, VectorPlace::device);
  there.adopt(device);
  there.store();
  ASSERT_EQ(by_host.steps.size(), 4U);
  ASSERT_EQ(by_device.steps.size(), 4U);
  const auto as_doubles = [](const std::vector<float>& v) { return Vector(v.begin(), v.end()); };
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_LT(relative_difference(as_doubles(by_device.steps[k]), as_doubles(by_host.steps[k])),
              1e-6);
    EXPECT_LT(relative_difference(as_doubles(by_device.changes[k]), as_doubles(by_host.changes[k])),
              1e-6);
  }
  EXPECT_EQ(there.step(), StepOutcome::progressed);
}

TEST_P(DeviceSteps, GoOnWithTheGradientOfARenewedCorrection) {
  Fitted fit(GetParam().regulariser, GetParam().scale);
  OptimiserState state;
  state.z = fit.function.coordinates(fit.start);
  start(fit.function, state);
  Steps steps = fit.steps(state, VectorPlace::device);
  for (int k = 0; k < 3; ++k) ASSERT_EQ(steps.step(), StepOutcome::progressed);
  steps.leave();
  Correction r = fit.objective.correction();
  for (double& x : r.ratio) x *= 1.01;
  fit.objective.set_correction(r);
  fit.objective.forget();
  state.value = fit.function.value(state.z);
  state.gradient = fit.function.gradient();
  steps.go_on();
  OptimiserState by_host = state;
  steps.store();
  by_host.steps = state.steps;
  by_host.changes = state.changes;
  EXPECT_EQ(state.gradient, by_host.gradient);
  ASSERT_EQ(steps.step(), StepOutcome::progressed);
  Steps host = fit.steps(by_host, VectorPlace::host);
  ASSERT_EQ(host.step(), StepOutcome::progressed);
  EXPECT_NEAR(state.value, by_host.value, 1e-6 * by_host.value);
}

INSTANTIATE_TEST_SUITE_P(
    Of, DeviceSteps,
    ::testing::Values(
        Kind{"H1", {RegulariserKind::h1}, {}, false},
        Kind{"HuberTvInTheFitsOwnScale", {RegulariserKind::huber_tv, 0.5}, AbsorptionScale(0.02)},
        Kind{
            "HuberTvWithSlopesOfR", {RegulariserKind::huber_tv, 0.5}, AbsorptionScale(0.02), true}),
    [](const auto& kind) { return std::string(kind.param.name); });

TEST_F(OnDevice, AStepTooFarIsTakenBackAndTheHostSolvesAnew) {
  Fitted fit({RegulariserKind::huber_tv, 0.5}, AbsorptionScale(0.02));
  OptimiserState state;
  state.z = fit.function.coordinates(fit.start);
  start(fit.function, state);
  for (double& g : state.gradient) g = -g;  // uphill
  const Vector before = state.z;
  Steps steps = fit.steps(state, VectorPlace::device);
  EXPECT_EQ(steps.step(), StepOutcome::stalled);
  const int solves = fit.objective.solves().forward;
  steps.leave();
  EXPECT_EQ(state.z, before);
  EXPECT_NEAR(fit.function.value(state.z), state.value, 1e-9 * state.value);
  EXPECT_EQ(fit.objective.solves().forward, solves + 1);
}

TEST_F(OnDevice, CoefficientsBeyondAnyRangeAreInfinitelyBad) {
  Fitted fit({}, {});
  DeviceFunction function(*arithmetic_, fit.objective, fit.basis,
                          {fit.function.anchor(), 1.0, {}, {}});
  for (const double bad : {26.0, std::nan(""), -HUGE_VAL}) {
    Vector logs = joined(fit.start);
    logs[logs.size() - 2] = bad;
    EXPECT_EQ(function.value(upload(logs)), HUGE_VAL) << bad;
  }
}

}  // namespace
}  // namespace kappamu::inverse
