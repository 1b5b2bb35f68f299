// Every OpenCL kernel against the serial reference, on awkward grids and batches; iteration bounds;
// what happens when a device is not to be trusted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "device/context.h"
#include "forward/grid/opencl/opencl_field.h"
#include "forward/grid/opencl/opencl_solver.h"
#include "forward/grid/solver_self_test.h"
#include "tests/forward/grid/backends.h"
#include "tests/forward/grid/test_tools.h"
#include "tests/sentence.h"

namespace kappamu::forward {

extern const device::KernelSource grid_flat_cl, grid_flat_residual_cl, grid_lanes_cl,
    grid_levels_cl, grid_stream_cl, grid_stream_residual_cl;

namespace {

using ::testing::HasSubstr;
using testing::Values;

struct Case {
  GridShape shape;
  int patterns;
  Face lit;
  Sides sides;
  SourceModel source;
};

// One, primes, long thin bars, powers of two and one more; every number of lanes, full and ragged.
const std::vector<Case> cases{
    {{1, 1, 1, 0.5}, 1, Face::z_minus, Sides::open, SourceModel::first_collision},
    {{1, 1, 1, 0.5}, 3, Face::x_plus, Sides::mirror, SourceModel::boundary},
    {{7, 13, 5, 0.3}, 3, Face::z_minus, Sides::open, SourceModel::first_collision},
    {{7, 13, 5, 0.3}, 16, Face::y_minus, Sides::mirror, SourceModel::boundary},
    {{1, 1, 17, 0.2}, 5, Face::z_plus, Sides::open, SourceModel::first_collision},
    {{1, 1, 17, 0.2}, 17, Face::z_minus, Sides::mirror, SourceModel::first_collision},
    {{31, 1, 3, 0.4}, 1, Face::x_minus, Sides::open, SourceModel::boundary},
    {{31, 1, 3, 0.4}, 21, Face::z_minus, Sides::mirror, SourceModel::first_collision},
    {{1, 29, 1, 0.4}, 4, Face::y_plus, Sides::open, SourceModel::first_collision},
    {{2, 2, 2, 1.0}, 9, Face::x_plus, Sides::open, SourceModel::boundary},
    {{16, 17, 4, 0.5}, 8, Face::y_plus, Sides::open, SourceModel::first_collision},
    {{37, 19, 3, 0.25}, 16, Face::z_minus, Sides::open, SourceModel::first_collision},
};

class GridEquivalence : public testing::OnBackend {
 protected:
  /// Relative residual 1e-12 in double leaves the condition of these small grids; in single the
  /// storage of φ and of the conductances dominates.
  static double tolerance() { return single() ? 1e-7 : 1e-12; }
  static double allowed() { return single() ? 3e-6 : 1e-9; }

  /// Every quantity of the interface on `device` and on the reference.
  static void compare(const Case& c, GridSolver& device);
};

void GridEquivalence::compare(const Case& c, GridSolver& device) {
  {
    std::ostringstream name;
    name << c.shape.nx << "x" << c.shape.ny << "x" << c.shape.nz << ", " << c.patterns
         << " patterns, lit " << to_string(c.lit);
    SCOPED_TRACE(name.str());
    GridSetup setup{.shape = c.shape, .lit_face = c.lit, .sides = c.sides, .source = c.source};
    const auto reference = make_reference_solver(setup);
    const auto medium = testing::random_medium(c.shape, 100, 21);
    const std::size_t samples =
        face_shape(c.shape, c.lit).cells() * static_cast<std::size_t>(c.patterns);
    const Values light = testing::random_values(samples, 0, 1, 22);
    const Values other =
        testing::random_values(c.shape.cells() * static_cast<std::size_t>(c.patterns), -1, 1, 23);

    const auto answers = [&](GridSolver& s, double tol) {
      s.set_medium(medium.kappa, medium.mu);
      std::vector<std::pair<std::string, Values>> found;
      const auto b = s.make_field(c.patterns);
      s.light_source(light, *b);
      found.emplace_back("source", testing::read(s, *b));
      const auto lambda = s.make_field(c.patterns);
      s.fill(*lambda, other);
      const auto image = s.make_field(c.patterns);
      s.apply(*lambda, *image);
      found.emplace_back("operator", testing::read(s, *image));
      const auto solution = testing::solve_light(s, light, c.patterns, {tol, 200});
      EXPECT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
      EXPECT_EQ(solution.report.residual.size(), static_cast<std::size_t>(c.patterns));
      found.emplace_back("fluence", testing::read(s, *solution.phi));
      for (const Face face : all_faces) {
        if (c.sides == Sides::mirror && axis_of(face) != axis_of(c.lit)) continue;
        const Values map =
            testing::exitance(s, *solution.phi, face, face == c.lit ? light : Values{});
        found.emplace_back("exitance " + to_string(face), map);
        s.exitance_adjoint(face, map, *image);
        found.emplace_back("adjoint " + to_string(face), testing::read(s, *image));
      }
      const PairProducts sums = s.pair_products(*lambda, *solution.phi);
      found.emplace_back("cells products", sums.cell);
      found.emplace_back("x products", sums.face_x);
      found.emplace_back("y products", sums.face_y);
      found.emplace_back("z products", sums.face_z);
      found.emplace_back("column products", s.column_products(*lambda, light));
      found.emplace_back("weighted sums", s.weighted_sums(*solution.phi, medium.mu));
      s.change_source({sums.face_x, sums.face_y, sums.face_z, sums.cell, medium.mu}, *lambda, light,
                      *image);
      found.emplace_back("change", testing::read(s, *image));
      return found;
    };
    const auto got = answers(device, tolerance());
    const auto expected = answers(*reference, 1e-13);
    // A face many decay lengths from the light is dark to below the solver's tolerance: maps are
    // held to the brightest face's norm, kind by kind.
    std::map<std::string, double> scale;
    const auto kind = [](const std::string& quantity) {
      return quantity.substr(0, quantity.find(' '));
    };
    for (const auto& [quantity, values] : expected) {
      scale[kind(quantity)] = std::max(scale[kind(quantity)], testing::norm(values));
    }
    for (std::size_t i = 0; i < got.size(); ++i) {
      Values difference = got[i].second;
      for (std::size_t k = 0; k < difference.size(); ++k) difference[k] -= expected[i].second[k];
      EXPECT_LE(testing::norm(difference), allowed() * scale[kind(got[i].first)]) << got[i].first;
    }
  }
}

TEST_P(GridEquivalence, EveryQuantityEqualsTheReference) {
  for (const Case& c : cases) {
    const auto device =
        solver({.shape = c.shape, .lit_face = c.lit, .sides = c.sides, .source = c.source});
    compare(c, *device);
  }
}

/// Work cut as for a GPU gives the same on any device.
TEST_P(GridEquivalence, TheOtherLayoutEqualsTheReferenceToo) {
  const auto devices = device::list_devices();
  const std::size_t index = device::choose(devices, GetParam().device).index;
  const Layout other = layout_of(devices[index]) == Layout::gpu ? Layout::cpu : Layout::gpu;
  for (const Case& c : cases) {
    if (c.patterns != full_lanes) continue;  // compiling every width again takes long
    const auto device = make_opencl_solver(
        {.shape = c.shape, .lit_face = c.lit, .sides = c.sides, .source = c.source},
        device::Context::of(index), {GetParam().precision, Trust::blind, other});
    compare(c, *device);
  }
}

/// Names of -D have defaults.
TEST(Kernels, EachProgramCompilesByItself) {
  if (device::list_devices().empty()) GTEST_SKIP() << "no OpenCL device is installed";
  device::Context& context = device::Context::chosen("auto");
  for (const device::KernelSource* source :
       {&grid_flat_cl, &grid_flat_residual_cl, &grid_lanes_cl, &grid_levels_cl, &grid_stream_cl,
        &grid_stream_residual_cl}) {
    EXPECT_NO_THROW(context.program(*source, "")) << source->path;
  }
}

TEST_P(GridEquivalence, FieldsComeBackAsTheyWent) {
  const GridShape shape{5, 3, 2, 1.0};
  const auto s = solver({.shape = shape});
  constexpr int patterns = 22;  // blocks of 16 and 8, the latter with two idle lanes
  Values sent(shape.cells() * patterns);
  for (std::size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<double>(i);  // exact in float
  const auto field = s->make_field(patterns);
  EXPECT_EQ(testing::norm(testing::read(*s, *field)), 0.0);
  s->fill(*field, sent);
  EXPECT_EQ(testing::read(*s, *field), sent);
}

/// A multigrid that degrades turns red. Measured on 256x256x20: 9 and 11, and the count must not
/// grow with the grid.
TEST_P(GridEquivalence, IterationsStayBounded) {
  struct Bound {
    double contrast;
    int iterations;
  };
  for (const int nx : {32, 96}) {
    const GridShape shape{nx, 64, 20, 0.25};
    for (const Bound bound : {Bound{10, 11}, Bound{1e4, 14}}) {
      Values kappa(shape.cells()), mu(shape.cells(), 1e-4);
      for (int z = 0; z < shape.nz; ++z) {
        for (int y = 0; y < shape.ny; ++y) {
          for (int x = 0; x < shape.nx; ++x) {
            const bool one = x >= nx / 8 && x < nx / 3 && y >= 9 && y < 27 && z >= 3 && z < 9;
            const bool two = x >= nx / 2 && x < nx - 5 && y >= 31 && y < 58 && z >= 8 && z < 17;
            kappa[shape.index(x, y, z)] = one || two ? 0.02 * bound.contrast : 0.02;
          }
        }
      }
      const auto s = solver({.shape = shape});
      s->set_medium(kappa, mu);
      const auto solution = testing::solve_light(
          *s, testing::random_values(static_cast<std::size_t>(nx) * 64 * 4, 0, 1, 24), 4,
          {1e-6, 100});
      EXPECT_EQ(solution.report.termination, Termination::converged) << solution.report.message;
      EXPECT_LE(solution.report.iterations, bound.iterations)
          << "contrast " << bound.contrast << ", nx " << nx;
    }
  }
}

/// The worst medium there is: κ jumps by up to 1e4 at every voxel. Measured: 27.
TEST_P(GridEquivalence, RandomJumpsOfFourDecadesAreSolved) {
  const GridShape shape{64, 64, 20, 0.25};
  const auto medium = testing::random_medium(shape, 1e4, 25);
  const auto s = solver({.shape = shape});
  s->set_medium(medium.kappa, medium.mu);
  const auto solution = testing::solve_light(
      *s, testing::random_values(std::size_t{64} * 64 * 4, 0, 1, 26), 4, {1e-6, 100});
  EXPECT_LE(solution.report.iterations, 34) << solution.report.message;
}

INSTANTIATE_TEST_SUITE_P(, GridEquivalence,
                         ::testing::Values(testing::opencl_single, testing::opencl_double),
                         testing::backend_name);

TEST(Blocks, WasteFewLanesAndCoverEveryPatternOnce) {
  for (const int most : {16, 8, 4, 1}) {
    for (int patterns = 1; patterns <= 40; ++patterns) {
      int next = 0;
      for (const Block& block : cut_into_blocks(patterns, most)) {
        EXPECT_EQ(block.first, next);
        EXPECT_LE(block.count, block.lanes);
        EXPECT_LE(block.lanes, most);
        next += block.count;
      }
      EXPECT_EQ(next, patterns);
    }
  }
}

TEST(SolverChoiceTest, ADistrustedDeviceIsReplacedLoudly) {
  const GridSetup setup{.shape = {3, 3, 3, 1.0}};
  const SolverChoice choice =
      trusted_or_reference(make_reference_solver(setup), setup, "Broken GPU", {false, "2 + 2 = 5"});
  EXPECT_EQ(choice.solver->backend(), "reference");
  EXPECT_THAT(choice.warning, HasSubstr("'Broken GPU' fails its known-answer test (2 + 2 = 5)"));
  EXPECT_THAT(choice.warning, HasSubstr("serial reference"));
}

TEST(SolverChoiceTest, UnknownDeviceIsOneSentence) {
  const std::string sentence = sentence_of([&] {
    make_grid_solver({.shape = {3, 3, 3, 1.0}}, "no such device");
  });
  EXPECT_THAT(sentence, HasSubstr("no OpenCL device matches 'no such device'"));
  EXPECT_THAT(sentence, HasSubstr("install pocl-opencl-icd or use the device reference"));
}

class GridInput : public testing::OnBackend {};

TEST_P(GridInput, BadCoefficientsNameTheVoxel) {
  const GridShape shape{3, 4, 5, 1.0};
  const auto s = solver({.shape = shape});
  const Values good_kappa(60, 0.3), good_mu(60, 0.01);
  Values kappa = good_kappa, mu = good_mu;
  kappa[shape.index(1, 2, 3)] = -0.1;
  EXPECT_THAT(sentence_of([&] { s->set_medium(kappa, good_mu); }),
              HasSubstr("kappa is -0.1 at voxel x=1 y=2 z=3"));
  mu[shape.index(2, 0, 4)] = std::nan("");
  EXPECT_THAT(sentence_of([&] { s->set_medium(good_kappa, mu); }),
              HasSubstr("mu is nan at voxel x=2 y=0 z=4"));
  EXPECT_THAT(sentence_of([&] { s->set_medium(good_kappa, Values(59, 0.0)); }),
              HasSubstr("mu 59 where the grid has 60 voxels"));
}

TEST_P(GridInput, BadSetupsNameTheField) {
  EXPECT_THAT(sentence_of([&] { solver({.shape = {3, 0, 5, 1.0}}); }), HasSubstr("3 x 0 x 5"));
  EXPECT_THAT(sentence_of([&] { solver({.shape = {3, 3, 5, 0.0}}); }), HasSubstr("voxel_mm"));
  EXPECT_THAT(sentence_of([&] {
                solver({.shape = {3, 3, 5, 1.0}, .convention = Convention::wang2008});
              }),
              HasSubstr("boundary source"));
  EXPECT_THAT(sentence_of([&] {
                solver({.shape = {3, 3, 5, 1.0}, .eta = 0.5});
              }),
              HasSubstr("eta"));
}

TEST_P(GridInput, UseBeforeTheMediumIsOurBug) {
  const auto s = solver({.shape = {3, 3, 3, 1.0}});
  const auto b = s->make_field(1), phi = s->make_field(1);
  EXPECT_THROW(s->solve(*b, *phi, {}), InternalError);
}

INSTANTIATE_TEST_SUITE_P(, GridInput,
                         ::testing::Values(testing::reference_backend, testing::opencl_single),
                         testing::backend_name);

}  // namespace
}  // namespace kappamu::forward
