// An object is fitted by what fits blocks: objective, metric, regulariser and optimiser take the
// operator's MediumSpace and know nothing of its shape.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>

#include "core/mesh/shapes.h"
#include "forward/embedded/embedded_operator.h"
#include "inverse/optimise/fit_function.h"
#include "inverse/optimise/lateral_hessian.h"
#include "tests/inverse/inverse_cases.h"

namespace kappamu::inverse {
namespace {

/// Rays against one triangle after the other.
class EveryTriangle final : public RayCaster {
 public:
  explicit EveryTriangle(const TriangleMesh& mesh) : mesh_(mesh) {}
  std::optional<RayHit> first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                  double nearest, double farthest) const override {
    std::optional<RayHit> best;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const auto vertex = [&](std::size_t k) {
        return mesh_.vertices[static_cast<std::size_t>(mesh_.triangles[t][k])];
      };
      Eigen::Matrix3d columns;
      columns << -direction, vertex(1) - vertex(0), vertex(2) - vertex(0);
      const Eigen::Vector3d hit = columns.inverse() * (origin - vertex(0));
      if (!(hit[1] >= 0.0 && hit[2] >= 0.0 && hit[1] + hit[2] <= 1.0)) continue;
      if (!(hit[0] > nearest && hit[0] < farthest)) continue;
      farthest = hit[0];
      best = RayHit{hit[0], static_cast<int>(t), hit[1], hit[2]};
    }
    return best;
  }

 private:
  const TriangleMesh& mesh_;
};

TEST(ObjectFit, FindsAnInclusionOfASphereUnderDiffuseLight) {
  const TriangleMesh mesh = sphere_mesh(4.0, 6);
  constexpr int patterns = 12;
  Problem problem;
  problem.setup = {.shape = forward::embedded::voxels_about(mesh, 3),
                   .source = forward::SourceModel::boundary};
  problem.patterns = patterns;
  // Each pattern lights the triangles of one side, evenly but for its own direction.
  const Surface surface = surface_of(mesh);
  for (int m = 0; m < patterns; ++m) {
    const double turn = 2.4 * m, height = 2.0 * (m + 0.5) / patterns - 1.0;
    const double ring = std::sqrt(1.0 - height * height);
    const Eigen::Vector3d to_light(ring * std::cos(turn), ring * std::sin(turn), height);
    for (const Eigen::Vector3d& normal : surface.normal) {
      problem.irradiance.push_back(std::max(0.0, normal.dot(to_light)));
    }
  }
  Backend backend{"reference", forward::Precision::double_precision, {1e-7, 300}};
  backend.operators =
      forward::embedded::object_operators(mesh, std::make_shared<EveryTriangle>(mesh));
  const auto op = backend.make(problem.setup, problem.seen_face).op;
  const MediumSpace& space = op->space();
  const CoefficientPair start{std::vector<double>(space.cells(), std::log(0.4)),
                              std::vector<double>(space.cells(), std::log(0.02))};
  CoefficientPair truth = start;
  for (int z = 0; z < space.shape.nz; ++z) {
    for (int y = 0; y < space.shape.ny; ++y) {
      for (int x = 0; x < space.shape.nx; ++x) {
        const bool dark = x >= 5 && std::abs(y - 3.5) < 2.0 && std::abs(z - 3.5) < 2.0;
        if (dark) truth.log_mu[space.shape.index(x, y, z)] += std::log(4.0);
      }
    }
  }
  op->set_medium(exponential(truth.log_kappa), exponential(truth.log_mu));
  problem.data = solve_exitance(*op, problem.irradiance, patterns, {patterns, {1e-9, 500}});
  cases::Noise noise(5);
  for (double& d : problem.data) {
    problem.weight.push_back(std::pow(0.003 * d, -2));
    d *= 1.0 + 0.003 * noise.normal();
  }

  // From strong to weak, as a fit of a block goes, to the noise.
  Objective objective(problem, backend);
  const Anchor anchor{std::log(0.4), std::log(0.02), 10.0 * space.thickness_mm};
  CoefficientPair found = start;
  objective.value(found);
  EXPECT_GT(objective.chi2_per_value(), 100.0);
  for (double weight = 1e5; objective.chi2_per_value() > 1.0 && weight > 10.0; weight *= 0.3) {
    const LateralBlocks blocks = lateral_blocks(random_rows(objective, 2, 1), space);
    const Basis basis(space, {Coordinates::informed, space.thickness_mm, weight}, blocks);
    FitFunction function(objective, basis, anchor, weight, {RegulariserKind::huber_tv, 1.0}, found);
    OptimiserState state;
    state.z = function.coordinates(found);
    inverse::start(function, state);
    for (int k = 0; k < 20; ++k) {
      if (step(function, state, {}) == StepOutcome::stalled) break;
    }
    found = function.fields(state.z);
    objective.value(found);
  }
  EXPECT_LT(objective.chi2_per_value(), 1.2);
  // Mean of log μ over what is dark, less that over its mirror image.
  double dark = 0.0, volume = 0.0;
  for (std::size_t i = 0; i < space.cells(); ++i) {
    const int x = static_cast<int>(i) % space.shape.nx;
    if (truth.log_mu[i] == start.log_mu[i]) continue;
    const double share = space.fraction[i];
    dark += share * (found.log_mu[i] - found.log_mu[i - 2 * x + space.shape.nx - 1]);
    volume += share;
  }
  EXPECT_NEAR(dark / volume, std::log(4.0), 0.4 * std::log(4.0)) << "smoothing takes of it";
}

}  // namespace
}  // namespace kappamu::inverse
