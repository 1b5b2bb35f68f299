// Monte Carlo's fluence, oblique beams and points: against diffusion deep inside, and against laws.
#include "core/optics.h"
#include "forward/forward_model.h"
#include "tests/forward/montecarlo/test_tools.h"

namespace kappamu::forward {
namespace {

class MonteCarloBlockLight : public testing::WithDevice {
 protected:
  /// σs' 1, μ 0.01 per mm: a transport mean free path of a millimetre.
  static ForwardProblem block() {
    ForwardProblem p;
    p.setup.shape = {24, 24, 20, 0.5};
    p.medium = testing::homogeneous(p.setup.shape, 0.01, 1.0);
    p.irradiance.assign(24 * 24, 0.0);
    return p;
  }
  static ForwardResult solve(const ForwardProblem& p, const char* method, std::uint64_t photons,
                             std::uint64_t seed = 1) {
    ForwardOptions options;
    options.photons = photons;
    options.seed = seed;
    options.fluence = true;
    Progress silent;
    return make_forward_model(method)->solve(p, options, silent);
  }
  /// Voxels at least three millimetres, three mean free paths, from `source` and from all faces.
  template <class Act>
  static void deep_inside(const GridShape& s, const Eigen::Vector3d& source, const Act& act) {
    for (int z = 6; z < s.nz - 6; ++z)
      for (int y = 6; y < s.ny - 6; ++y)
        for (int x = 6; x < s.nx - 6; ++x) {
          const Eigen::Vector3d at(0.5 * x + 0.25, 0.5 * y + 0.25, 0.5 * z + 0.25);
          if ((at - source).norm() >= 3.0) act(s.index(x, y, z));
        }
  }
  static void agree_deep_inside(const ForwardProblem& p, const Eigen::Vector3d& source,
                                double diffusion_error) {
    constexpr std::uint64_t photons = 200'000;
    const ForwardResult transport = solve(p, "montecarlo", photons);
    const ForwardResult diffusion = solve(p, "multigrid", photons);
    const PowerBalance& t = transport.balance[0];
    const PowerBalance& d = diffusion.balance[0];
    EXPECT_NEAR(t.entering, d.entering, 1e-6 * d.entering);
    const double three_errors = 3.0 * std::sqrt(d.unscattered / d.entering / photons);
    EXPECT_NEAR(t.unscattered / t.entering, d.unscattered / d.entering, three_errors + 1e-6);
    // The mean over all those voxels, whose noise is small, and each within its own noise.
    double sum = 0.0, expected = 0.0;
    int voxels = 0, beyond = 0;
    deep_inside(p.setup.shape, source, [&](std::size_t i) {
      sum += transport.fluence[i];
      expected += diffusion.fluence[i];
      const double off = std::abs(transport.fluence[i] - diffusion.fluence[i]);
      const double noise = transport.fluence_error[i];
      ++voxels;
      beyond += off > 3.0 * noise + diffusion_error * diffusion.fluence[i] ? 1 : 0;
    });
    EXPECT_NEAR(sum / expected, 1.0, diffusion_error);
    // Student's t of nine degrees of freedom is beyond three in 1.5 %.
    EXPECT_LT(beyond, 0.02 * voxels) << "of " << voxels;
  }
};

TEST_F(MonteCarloBlockLight, APointIsThatOfDiffusionDeepInside) {
  ForwardProblem p = block();
  const Eigen::Vector3d at(6.25, 6.25, 4.25);
  p.light.points = {{at, 3.0}};
  agree_deep_inside(p, at, 0.03);
}

TEST_F(MonteCarloBlockLight, AnObliqueSpotIsThatOfDiffusionDeepInside) {
  ForwardProblem p = block();
  for (int v = 6; v < 10; ++v)
    for (int u = 6; u < 10; ++u) p.irradiance[static_cast<std::size_t>(v * 24 + u)] = 2.0;
  p.light.direction = Eigen::Vector3d(0.7, 0.3, 0.5);
  // Diffusion is 4 % too bright there at normal incidence, too.
  agree_deep_inside(p, {4.0, 4.0, 0.0}, 0.06);
}

// In a nearly clear block most of it is unscattered, and by which way it goes is seen.
TEST_F(MonteCarloBlockLight, ObliqueLightWithoutCollisionsIsThatOfTheRays) {
  for (const Face face : all_faces) {
    for (const Sides sides : {Sides::open, Sides::mirror}) {
      ForwardProblem p;
      p.setup.shape = {6, 5, 4, 0.5};
      p.setup.lit_face = face;
      p.setup.sides = sides;
      p.medium = testing::homogeneous(p.setup.shape, 0.05, 0.1);
      p.irradiance.assign(face_shape(p.setup.shape, face).cells(), 0.0);
      p.irradiance[3] = 1.0;
      Eigen::Vector3d direction(0.7, -0.6, 0.5);
      direction[axis_of(face)] = is_plus(face) ? -0.8 : 0.8;
      p.light.direction = direction;
      constexpr std::uint64_t photons = 40'000;
      const PowerBalance t = solve(p, "montecarlo", photons).balance[0];
      const PowerBalance d = solve(p, "reference", photons).balance[0];
      const double share = d.unscattered / d.entering;
      EXPECT_GT(share, 0.1);
      const double error = std::sqrt(share * (1.0 - share) / photons);
      constexpr double of_sixteen_rays = 0.01;  // at a pixel's edges
      EXPECT_NEAR(t.unscattered / t.entering, share, 4.0 * error + of_sixteen_rays)
          << to_string(face);
    }
  }
}

// Light absorbed is μ φ over the block, once what was absorbed at first collisions is added.
TEST_F(MonteCarloBlockLight, FluenceTimesMuIsWhatIsAbsorbed) {
  ForwardProblem p = block();
  p.patterns = 2;
  p.irradiance.assign(2 * 24 * 24, 1.0);
  std::fill(p.irradiance.begin() + 24 * 24, p.irradiance.end(), 0.0);
  p.light.points = {{{3.1, 4.2, 5.3}, 1.0}};
  constexpr std::uint64_t photons = 40'000;
  const ForwardResult result = solve(p, "montecarlo", photons);
  const std::size_t cells = p.setup.shape.cells();
  for (std::size_t m = 0; m < 2; ++m) {
    const PowerBalance& balance = result.balance[m];
    double absorbed = 0.0;
    for (std::size_t i = m * cells; i < (m + 1) * cells; ++i)
      absorbed += 0.01 * result.fluence[i] * std::pow(0.5, 3);
    if (m == 0) absorbed += (balance.entering - balance.unscattered) * 0.01 / 1.01;
    // Both tallies are of the same photons; an absorption is rarer than a visit.
    const double share = balance.absorbed / balance.entering;
    EXPECT_NEAR(absorbed / balance.absorbed, 1.0, 4.0 / std::sqrt(share * photons)) << m;
  }
}

TEST_F(MonteCarloBlockLight, StandardErrorsOfFluenceAreTrue) {
  ForwardProblem p = block();
  p.setup.shape = {4, 4, 4, 1.0};
  p.medium = testing::homogeneous(p.setup.shape, 0.05, 1.0);
  p.irradiance.assign(16, 0.0);
  p.light.points = {{{1.7, 2.2, 1.9}, 1.0}};
  constexpr int repetitions = 60;
  const std::size_t cells = p.setup.shape.cells();
  std::vector<double> sum(cells, 0.0), squares(cells, 0.0), stated(cells, 0.0);
  for (int r = 0; r < repetitions; ++r) {
    const ForwardResult result = solve(p, "montecarlo", 2'000, static_cast<std::uint64_t>(r + 1));
    for (std::size_t i = 0; i < cells; ++i) {
      sum[i] += result.fluence[i];
      squares[i] += result.fluence[i] * result.fluence[i];
      stated[i] += result.fluence_error[i] * result.fluence_error[i];
    }
  }
  double ratio = 0.0;
  for (std::size_t i = 0; i < cells; ++i) {
    const double variance = (squares[i] - sum[i] * sum[i] / repetitions) / (repetitions - 1.0);
    ratio += variance / (stated[i] / repetitions) / static_cast<double>(cells);
  }
  // Of one voxel √(2/59 + 2/540) = 0.19; of 64 that share photons, a few times less.
  EXPECT_NEAR(ratio, 1.0, 0.15);
}

}  // namespace
}  // namespace kappamu::forward
