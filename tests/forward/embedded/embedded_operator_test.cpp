// An object is fitted through the same operator as a block: transposes, derivatives and the
// medium's share inside.
#include "forward/embedded/embedded_operator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.h"
#include "core/mesh/shapes.h"
#include "core/numbers/dot.h"
#include "tests/forward/embedded/embedded_test_tools.h"

namespace kappamu::forward::embedded {
namespace {

constexpr int level = 3;
constexpr int patterns = 2;
constexpr SolveOptions exact{1e-12, 500};

/// A cone, whose surface cuts cubes in every way, with a rough medium.
class ObjectOperator : public testing::Test {
 protected:
  void SetUp() override {
    op = object_operators(mesh, make_caster(mesh))
             ->make(setup, Face::z_minus, "reference", Precision::double_precision)
             .op;
    at = {random(cells()), random(cells())};
    for (double& x : at.log_kappa) x = std::log(0.4) + 0.5 * x;
    for (double& x : at.log_mu) x = std::log(0.05) + 0.5 * x;
    light = random(patterns * op->light_size());
    weights = random(patterns * op->exitance_size());
    for (double& x : light) x = std::abs(x);
  }
  std::size_t cells() const { return op->space().cells(); }
  std::vector<double> random(std::size_t size) {
    std::uniform_real_distribution<double> numbers(-1.0, 1.0);
    std::vector<double> values(size);
    for (double& x : values) x = numbers(engine);
    return values;
  }
  std::unique_ptr<BatchField> solved(const BatchField& b) const {
    auto field = op->make_field(patterns);
    EXPECT_EQ(op->solve(b, *field, exact).termination, Termination::converged);
    return field;
  }
  void set_medium(const CoefficientPair& logs) const {
    std::vector<double> kappa, mu;
    for (const double x : logs.log_kappa) kappa.push_back(std::exp(x));
    for (const double x : logs.log_mu) mu.push_back(std::exp(x));
    op->set_medium(kappa, mu);
  }
  /// φ and M at these logarithms.
  std::unique_ptr<BatchField> light_up(const CoefficientPair& logs, std::vector<double>& exitance) {
    set_medium(logs);
    const auto b = op->make_field(patterns);
    op->load(light, *b);
    auto phi = solved(*b);
    exitance.resize(weights.size());
    op->exitance(*phi, light, exitance);
    return phi;
  }

  std::mt19937_64 engine{23};
  TriangleMesh mesh = cone_mesh(4.0, 7.0, 6);
  GridSetup setup{.shape = voxels_about(mesh, level), .source = SourceModel::boundary};
  std::unique_ptr<DiffusionOperator> op;
  CoefficientPair at;
  std::vector<double> light, weights;
};

TEST_F(ObjectOperator, ItsVoxelsFillTheObject) {
  double volume = 0.0;
  for (const float share : op->space().fraction) volume += share;
  volume *= std::pow(setup.shape.voxel_mm, 3);
  EXPECT_NEAR(volume, enclosed_volume(mesh), 1e-5 * volume);
  EXPECT_LT(op->space().fraction.front(), 1.0F) << "corners of the root cube are outside";
}

TEST_F(ObjectOperator, LightAndExitanceAreEachOthersTranspose) {
  set_medium(at);
  const auto b = op->make_field(patterns);
  op->load(light, *b);
  std::vector<double> seen(weights.size()), back(light.size());
  op->exitance(*solved(*b), std::vector<double>(light.size(), 0.0), seen);
  op->exitance_transpose(weights, *b);
  op->load_transpose(*solved(*b), back);
  EXPECT_NEAR(dot(seen, weights) / dot(light, back), 1.0, 1e-9);
}

TEST_F(ObjectOperator, TheGradientIsTheDiscreteModelsOwn) {
  std::vector<double> exitance;
  const auto phi = light_up(at, exitance);
  const SolvedBatch here{*phi, light, exitance};
  const auto b = op->make_field(patterns);
  op->exitance_transpose(weights, *b);
  CoefficientPair gradient{std::vector<double>(cells(), 0.0), std::vector<double>(cells(), 0.0)};
  op->add_gradient(here, *solved(*b), weights, gradient);
  const CoefficientPair direction{random(cells()), random(cells())};
  const double slope =
      dot(gradient.log_kappa, direction.log_kappa) + dot(gradient.log_mu, direction.log_mu);

  std::vector<double> change(weights.size()), by_fluence(weights.size());
  op->linearise(here, direction, *b, change);
  op->exitance(*solved(*b), std::vector<double>(light.size(), 0.0), by_fluence);
  EXPECT_NEAR((dot(change, weights) + dot(by_fluence, weights)) / slope, 1.0, 1e-8)
      << "tangent and adjoint are each other's transpose";

  for (std::size_t i = 0; i < cells(); ++i) {
    if (!op->space().inside(i)) {
      EXPECT_EQ(gradient.log_kappa[i], 0.0);
    }
  }
  std::vector<double> remainder;
  for (const double step : {0.04, 0.02, 0.01}) {
    CoefficientPair moved = at;
    for (std::size_t i = 0; i < cells(); ++i) {
      moved.log_kappa[i] += step * direction.log_kappa[i];
      moved.log_mu[i] += step * direction.log_mu[i];
    }
    std::vector<double> there;
    light_up(moved, there);
    remainder.push_back(std::abs(dot(there, weights) - dot(exitance, weights) - step * slope));
  }
  EXPECT_NEAR(std::log2(remainder[0] / remainder[1]), 2.0, 0.15);
  EXPECT_NEAR(std::log2(remainder[1] / remainder[2]), 2.0, 0.15);
}

TEST_F(ObjectOperator, OtherVoxelsAndCollimatedLightAreRefused) {
  const auto factory = object_operators(mesh, make_caster(mesh));
  const auto make = [&](const GridSetup& other) {
    return factory->make(other, Face::z_minus, "reference", Precision::double_precision);
  };
  GridSetup odd = setup;
  odd.shape.nx = 7;
  EXPECT_THROW(make(odd), InputError);
  GridSetup beam = setup;
  beam.source = SourceModel::first_collision;
  EXPECT_THROW(make(beam), InputError);
}

}  // namespace
}  // namespace kappamu::forward::embedded
