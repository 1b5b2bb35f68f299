// Thin, long, prime and single-voxel grids; mirrors without absorption.
#include <gtest/gtest.h>

#include "forward/grid/grid_physics.h"
#include "tests/stability/bounds.h"
#include "tests/stability/stability_tools.h"

namespace kappamu::test_cases {
namespace {

using forward::SourceModel;
using forward::Termination;

class Shape : public testing::OnDevice, public ::testing::WithParamInterface<GridShape> {};

TEST_P(Shape, IsSolvedLikeAnyOther) {
  constexpr int most = 16;  // at contrast 10, whatever the shape
  const LimitOutcome outcome = run_limit(
      {.setup = {.shape = GetParam()}, .medium = {.kind = MediumKind::random, .contrast = 10}});
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.message;
  EXPECT_LE(outcome.iterations, most);
  EXPECT_LT(*outcome.true_error, bounds::single_error);
  EXPECT_LT(outcome.imbalance, bounds::imbalance);
}

INSTANTIATE_TEST_SUITE_P(, Shape,
                         ::testing::Values(GridShape{24, 24, 1, 0.25}, GridShape{24, 24, 2, 0.25},
                                           GridShape{24, 24, 3, 0.25}, GridShape{24, 24, 4, 0.25},
                                           GridShape{1, 24, 24, 0.25}, GridShape{2, 24, 24, 0.25},
                                           GridShape{24, 3, 24, 0.25}, GridShape{24, 4, 24, 0.25},
                                           GridShape{31, 17, 13, 0.25}, GridShape{67, 61, 7, 0.25},
                                           GridShape{1000, 7, 3, 0.25}, GridShape{7, 1000, 3, 0.25},
                                           GridShape{3, 7, 1000, 0.25}, GridShape{1, 1, 500, 0.25},
                                           GridShape{500, 1, 1, 0.25}, GridShape{1, 1, 1, 0.25}),
                         [](const auto& at) {
                           const GridShape& s = at.param;
                           return std::to_string(s.nx) + "x" + std::to_string(s.ny) + "x" +
                                  std::to_string(s.nz);
                         });

/// The lit face and its opposite carry the Robin condition under every setup, so the equations
/// cannot be singular: mirrors close four faces at most.
TEST(MirrorSides, LeaveTwoFacesOpen) {
  for (const Face lit : all_faces) {
    const forward::GridSetup setup{
        .shape = {3, 3, 3, 1.0}, .lit_face = lit, .sides = Sides::mirror};
    int open = 0;
    for (const Face face : all_faces) open += forward::is_open(setup, face) ? 1 : 0;
    EXPECT_EQ(open, 2);
    EXPECT_TRUE(forward::is_open(setup, lit) && forward::is_open(setup, opposite(lit)));
  }
}

class MirrorsWithoutAbsorption : public testing::OnDevice,
                                 public ::testing::WithParamInterface<int> {};

/// φ of a real solve against resistances in series.
struct Compared {
  forward::SolveReport report;
  double error = 0.0;
};
Compared solve_between_mirrors(int depth, double kappa, forward::Precision precision) {
  const GridShape shape{5, 4, depth, 0.25};
  const forward::GridSetup setup{
      .shape = shape, .sides = Sides::mirror, .source = SourceModel::boundary};
  const auto solver = forward::make_grid_solver(setup, "auto", precision).solver;
  const Medium medium = make_medium(shape, {.mean_kappa = kappa, .mu = 0.0});
  solver->set_medium(medium.kappa.values(), medium.mu.values());
  const auto b = solver->make_field(1), phi = solver->make_field(1);
  solver->light_source(patch_light(shape, Face::z_minus, 1), *b);
  Compared compared{solver->solve(*b, *phi, {}), 0.0};
  std::vector<double> values(shape.cells());
  solver->read(*phi, values);
  const double q = forward::boundary_q_per_irradiance(setup, solver->constants());
  compared.error =
      worst_difference(values, testing::series_fluence(medium.kappa, solver->constants().A, q), 1);
  return compared;
}

TEST_P(MirrorsWithoutAbsorption, HaveOneSolutionHoweverDeepInDouble) {
  for (const double kappa : {1e-3, 0.3, 1e3}) {
    const Compared compared =
        solve_between_mirrors(GetParam(), kappa, forward::Precision::double_precision);
    EXPECT_EQ(compared.report.termination, Termination::converged) << compared.report.message;
    EXPECT_LT(compared.error, bounds::weak_sink_error) << kappa;
  }
}

/// Of what strong bonds carry float rounds off more than leaves here; black cells are solved for to
/// second order so that it is not lost (docs/engine.md).
TEST_P(MirrorsWithoutAbsorption, AreAsRightInFloatAsAnythingElse) {
  for (const double kappa : {1e-3, 0.3, 1e3}) {
    const Compared compared =
        solve_between_mirrors(GetParam(), kappa, forward::Precision::single_precision);
    EXPECT_EQ(compared.report.termination, Termination::converged) << compared.report.message;
    EXPECT_LE(compared.report.iterations, bounds::weak_sink_iterations) << kappa;
    EXPECT_LT(compared.error, bounds::weak_sink_error) << kappa;
  }
}

INSTANTIATE_TEST_SUITE_P(, MirrorsWithoutAbsorption, ::testing::Values(1, 2, 16, 256, 2048));

}  // namespace
}  // namespace kappamu::test_cases
