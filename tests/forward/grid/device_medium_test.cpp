// Medium and gradient in the memory of a device beside those by the host.
#include "forward/device_medium.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "forward/grid/opencl/opencl_solver.h"
#include "tests/forward/grid/backends.h"
#include "tests/forward/grid/test_tools.h"

namespace kappamu::forward::testing {
namespace {

struct DeviceCase {
  const char* name;
  GridSetup setup;
  std::vector<Face> seen;
  int patterns;
};

void PrintTo(const DeviceCase& c, std::ostream* out) {
  *out << c.name;
}

GridSetup setup_of(const GridShape& shape, Face lit, Sides sides, SourceModel source) {
  GridSetup setup;
  setup.shape = shape;
  setup.lit_face = lit;
  setup.sides = sides;
  setup.source = source;
  return setup;
}

Values joined(const CoefficientPair& fields) {
  Values both = fields.log_kappa;
  both.insert(both.end(), fields.log_mu.begin(), fields.log_mu.end());
  return both;
}

class DeviceMediumOf : public ::testing::TestWithParam<DeviceCase> {
 protected:
  void SetUp() override {
    const std::vector<device::DeviceInfo> devices = device::list_devices();
    if (devices.empty()) GTEST_SKIP() << "no OpenCL device is installed";
    const std::size_t index = device::choose(devices, "auto").index;
    if (!devices[index].fp64) GTEST_SKIP() << "the device has no double precision";
    context_ = &device::Context::of(index);
  }
  std::unique_ptr<DiffusionOperator> made() const {
    const DeviceCase& c = GetParam();
    return make_grid_operator(make_opencl_solver(c.setup, *context_, {Precision::double_precision}),
                              SeenFaces(c.seen));
  }
  device::Buffer uploaded(const Values& values) const {
    device::Buffer buffer = context_->allocate(values.size() * sizeof(double));
    context_->write(buffer, values.data(), values.size() * sizeof(double));
    return buffer;
  }
  Values read(const device::Buffer& buffer) const {
    Values values(buffer.bytes() / sizeof(double));
    context_->read(buffer, values.data(), buffer.bytes());
    return values;
  }

  device::Context* context_ = nullptr;
};

TEST_P(DeviceMediumOf, GivesTheExitanceAndTheGradientOfTheHosts) {
  const DeviceCase& c = GetParam();
  const std::size_t cells = c.setup.shape.cells();
  CoefficientPair logs{random_values(cells, -2.5, 0.5, 1), random_values(cells, -6.0, 0.3, 2)};
  CoefficientPair medium = logs;
  for (double& k : medium.log_kappa) k = std::exp(k);
  for (double& m : medium.log_mu) m = std::exp(m);
  const auto host = made(), device = made();
  host->set_medium(medium.log_kappa, medium.log_mu);
  ASSERT_NE(device->on_device(), nullptr);
  DeviceMedium& there = *device->on_device();
  there.set(uploaded(joined(logs)));

  const auto patterns = static_cast<std::size_t>(c.patterns);
  const Values light = random_values(host->light_size() * patterns, 0.0, 1.0, 3);
  const Values weights = random_values(host->exitance_size() * patterns, -1.0, 1.0, 4);
  const Values before = random_values(2 * cells, -1e-3, 1e-3, 5);
  const auto solved = [&](const DiffusionOperator& op, const BatchField& b) {
    auto x = op.make_field(c.patterns);
    EXPECT_EQ(op.solve(b, *x, {1e-10, 200}).termination, Termination::converged);
    return x;
  };
  const auto b = host->make_field(c.patterns), b_there = device->make_field(c.patterns);
  host->load(light, *b);
  const auto phi = solved(*host, *b);
  Values exitance(weights.size());
  host->exitance(*phi, light, exitance);
  host->exitance_transpose(weights, *b);
  const auto lambda = solved(*host, *b);
  const auto half = before.begin() + static_cast<long>(cells);
  CoefficientPair gradient{Values(before.begin(), half), Values(half, before.end())};
  host->add_gradient({*phi, light, exitance}, *lambda, weights, gradient);

  const device::Buffer light_there = uploaded(light), weights_there = uploaded(weights);
  const device::Buffer exitance_there = uploaded(weights), gradient_there = uploaded(before);
  there.load(light_there, *b_there);
  const auto phi_there = solved(*device, *b_there);
  there.exitance(*phi_there, light_there, exitance_there);
  there.exitance_transpose(weights_there, *b_there);
  const auto lambda_there = solved(*device, *b_there);
  there.add_gradient({*phi_there, light_there, exitance_there}, *lambda_there, weights_there,
                     gradient_there);
  EXPECT_LT(relative_difference(read(exitance_there), exitance), 1e-9);
  const Values found = read(gradient_there);
  const auto middle = found.begin() + static_cast<long>(cells);
  EXPECT_LT(relative_difference(Values(found.begin(), middle), gradient.log_kappa), 1e-8);
  EXPECT_LT(relative_difference(Values(middle, found.end()), gradient.log_mu), 1e-8);

  // What the host needs of the medium it reads back.
  Values host_light(light.size()), device_light(light.size());
  host->exitance_transpose(weights, *b);
  host->load_transpose(*b, host_light);
  device->exitance_transpose(weights, *b_there);
  device->load_transpose(*b_there, device_light);
  EXPECT_LT(relative_difference(device_light, host_light), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(
    Blocks, DeviceMediumOf,
    ::testing::Values(DeviceCase{"beam_through",
                                 setup_of({13, 9, 6, 0.3}, Face::z_minus, Sides::open,
                                          SourceModel::first_collision),
                                 {Face::z_plus},
                                 3},
                      DeviceCase{"beam_back_from_plus_x",
                                 setup_of({5, 12, 7, 0.2}, Face::x_plus, Sides::mirror,
                                          SourceModel::first_collision),
                                 {Face::x_plus, Face::x_minus},
                                 18},
                      DeviceCase{"diffuse_along_y",
                                 setup_of({8, 6, 11, 0.5}, Face::y_minus, Sides::open,
                                          SourceModel::boundary),
                                 {Face::y_minus, Face::y_plus},
                                 5}),
    [](const auto& of) { return std::string(of.param.name); });

TEST(ReferenceSolver, KeepsNoMediumOnADevice) {
  GridSetup setup;
  setup.shape = {3, 3, 3, 0.5};
  EXPECT_EQ(make_grid_operator(make_reference_solver(setup), Face::z_plus)->on_device(), nullptr);
}

}  // namespace
}  // namespace kappamu::forward::testing
