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
  device::Buffer uploaded(const CoefficientPair& fields) const {
    const std::size_t bytes = fields.log_mu.size() * sizeof(double);
    device::Buffer both = context_->allocate(2 * bytes);
    std::vector<double> joined = fields.log_kappa;
    joined.insert(joined.end(), fields.log_mu.begin(), fields.log_mu.end());
    context_->write(both, joined.data(), 2 * bytes);
    return both;
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
  device->on_device()->set(uploaded(logs));

  const auto patterns = static_cast<std::size_t>(c.patterns);
  const Values light = random_values(host->light_size() * patterns, 0.0, 1.0, 3);
  const Values weights = random_values(host->exitance_size() * patterns, -1.0, 1.0, 4);
  const Values before = random_values(2 * cells, -1e-3, 1e-3, 5);
  const SolveOptions options{1e-10, 200};
  const auto fields_of = [&](DiffusionOperator& op, Values& exitance, const auto& gradient_of) {
    const auto b = op.make_field(c.patterns), phi = op.make_field(c.patterns),
               lambda = op.make_field(c.patterns);
    op.load(light, *b);
    ASSERT_EQ(op.solve(*b, *phi, options).termination, Termination::converged);
    exitance.resize(weights.size());
    op.exitance(*phi, light, exitance);
    op.exitance_transpose(weights, *b);
    ASSERT_EQ(op.solve(*b, *lambda, options).termination, Termination::converged);
    gradient_of(SolvedBatch{*phi, light, exitance}, *lambda);
  };
  Values by_host, by_device;
  CoefficientPair gradient{Values(before.begin(), before.begin() + static_cast<long>(cells)),
                           Values(before.begin() + static_cast<long>(cells), before.end())};
  fields_of(*host, by_host, [&](const SolvedBatch& at, const BatchField& lambda) {
    host->add_gradient(at, lambda, weights, gradient);
  });
  const device::Buffer on_device =
      uploaded({Values(before.begin(), before.begin() + static_cast<long>(cells)),
                Values(before.begin() + static_cast<long>(cells), before.end())});
  fields_of(*device, by_device, [&](const SolvedBatch& at, const BatchField& lambda) {
    device->on_device()->add_gradient(at, lambda, weights, on_device);
  });
  EXPECT_LT(relative_difference(by_device, by_host), 1e-9);
  Values found(2 * cells);
  context_->read(on_device, found.data(), found.size() * sizeof(double));
  const Values kappa(found.begin(), found.begin() + static_cast<long>(cells));
  const Values mu(found.begin() + static_cast<long>(cells), found.end());
  EXPECT_LT(relative_difference(kappa, gradient.log_kappa), 1e-8);
  EXPECT_LT(relative_difference(mu, gradient.log_mu), 1e-8);

  // What the host needs of the medium it reads back.
  Values host_light(light.size()), device_light(light.size());
  const auto lambda = host->make_field(c.patterns);
  host->exitance_transpose(weights, *lambda);
  host->load_transpose(*lambda, host_light);
  const auto same = device->make_field(c.patterns);
  device->exitance_transpose(weights, *same);
  device->load_transpose(*same, device_light);
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
