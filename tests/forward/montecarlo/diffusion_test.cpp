// Diffusion held to Monte Carlo: slabs under a patch of light, in absolute units, under the
// physical convention. Diffusion may differ by three standard errors plus its stated error.
#include <array>
#include <numeric>
#include <string>

#include "forward/analytic/layered_mode.h"
#include "forward/forward_model.h"
#include "tests/forward/montecarlo/test_tools.h"

namespace kappamu::forward {
namespace {

/// What diffusion with the first-collision source is off by on slabs like these, from a study with
/// another Monte Carlo program (docs/theory.md): 0.8 % in the light of the back face at 8 transport
/// mean free paths, 0.9 % at 21, 1.3 % in its map; and what voxels of a tenth of the thickness add.
struct StatedError {
  double back, back_map, front, absorbed;
};

/// The same problem by both methods.
struct Solved {
  Solved(const ForwardProblem& problem, std::uint64_t photons) {
    ForwardOptions options;
    options.photons = photons;
    Progress silent;
    diffusion = make_forward_model("multigrid")->solve(problem, options, silent);
    transport = make_forward_model("montecarlo")->solve(problem, options, silent);
    EXPECT_NEAR(transport.balance[0].entering, diffusion.balance[0].entering,
                1e-6 * diffusion.balance[0].entering);
  }
  ForwardResult diffusion, transport;
};

class MonteCarloReferee : public testing::WithDevice {
 protected:
  /// Means over n × n pixels of a square map.
  static std::vector<double> block_means(const std::vector<double>& map, int width, int n) {
    const int blocks = width / n;
    std::vector<double> means(static_cast<std::size_t>(blocks) * blocks, 0.0);
    for (int y = 0; y < width; ++y) {
      for (int x = 0; x < width; ++x) {
        means[static_cast<std::size_t>(y / n) * blocks + x / n] +=
            map[static_cast<std::size_t>(y) * width + x] / (n * n);
      }
    }
    return means;
  }

  static void compare(double thickness_mm, double scattering, double absorption, double voxel_mm,
                      int block, std::uint64_t photons, const StatedError& stated) {
    ForwardProblem problem;
    const int width = static_cast<int>(std::lround(24.0 / voxel_mm));
    problem.setup.shape = {width, width, static_cast<int>(std::lround(thickness_mm / voxel_mm)),
                           voxel_mm};
    const GridShape& s = problem.setup.shape;
    problem.medium = testing::homogeneous(s, absorption, scattering);
    problem.irradiance.assign(static_cast<std::size_t>(width) * width, 0.0);
    for (int y = 0; y < width; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool lit = std::abs(x + 0.5 - 0.5 * width) * voxel_mm < 2.0 &&
                         std::abs(y + 0.5 - 0.5 * width) * voxel_mm < 2.0;
        if (lit) problem.irradiance[static_cast<std::size_t>(y) * width + x] = 0.0625;
      }
    }
    const auto [diffusion, transport] = Solved(problem, photons);
    const PowerBalance& d = diffusion.balance[0];
    const PowerBalance& t = transport.balance[0];
    // Of a chance p per photon; exact where a photon leaves with all its weight, else above.
    const auto noise = [&](double power) {
      return std::sqrt(power / t.entering / static_cast<double>(photons)) * t.entering;
    };
    const auto expect = [&](const char* name, double theirs, double ours, double error) {
      EXPECT_NEAR(theirs, ours, 3.0 * noise(ours) + error * ours) << name;
      RecordProperty(std::string(name) + "_ratio", std::to_string(theirs / ours));
    };
    expect("back", d.exiting[5], t.exiting[5], stated.back);
    expect("front", d.exiting[4], t.exiting[4], stated.front);
    expect("absorbed", d.absorbed, t.absorbed, stated.absorbed);
    EXPECT_NEAR(t.unscattered, d.unscattered, 3.0 * noise(d.unscattered));

    // Σ(M_d − M_t)² over blocks of pixels is the model's part plus the noise of M_t, Σσ², which
    // itself spreads by √(2Σσ⁴).
    const std::vector<double> theirs = block_means(diffusion.exitance[5], width, block);
    const std::vector<double> ours = block_means(transport.exitance[5], width, block);
    std::vector<double> variances = transport.standard_error[5];
    for (double& v : variances) v *= v / (block * block);  // of a mean over block² pixels
    variances = block_means(variances, width, block);
    double difference = 0.0, norm = 0.0, variance = 0.0, spread = 0.0;
    for (std::size_t k = 0; k < ours.size(); ++k) {
      difference += std::pow(theirs[k] - ours[k], 2);
      norm += ours[k] * ours[k] - variances[k];
      variance += variances[k];
      spread += 2.0 * variances[k] * variances[k];
    }
    const double model = stated.back_map * stated.back_map * norm;
    EXPECT_LE(difference, model + variance + 3.0 * std::sqrt(spread));
    RecordProperty("map_error",
                   std::to_string(std::sqrt(std::max(0.0, difference - variance) / norm)));
    // Noise must not hide the stated error.
    EXPECT_LT(variance, model);
  }
};

// Even light on slabs of 1 to 3 mean free paths. What leaves unscattered is exact, and tells a
// reflected beam from one that is let out whole. docs/montecarlo.md has the recorded numbers.
TEST_F(MonteCarloReferee, ThinSlabsReturnTheBeam) {
  constexpr std::uint64_t photons = 1'000'000;
  constexpr double albedo = 0.99;
  for (const double eta : {1.3, 1.5}) {
    for (const int paths : {1, 2, 3}) {
      const double thickness = paths;
      const testing::SlabLight walk =
          testing::trace_slab(context(), {1.0 - albedo, albedo, 0.0, thickness, eta}, photons);
      const BoundaryConstants constants = boundary_constants(eta);
      const std::array<Layer, 1> layer{{{1.0 / 3.0, 1.0 - albedo, thickness}}};
      const auto slab = [&](double reflectance) {
        return LayeredMode(layer, constants.A, {0.0, 1.0, 0.0, reflectance});
      };
      const LayeredMode ours = slab(fresnel_internal(eta, 1.0)), whole = slab(0.0);
      const auto unscattered = [](const LayeredMode& mode) {
        return mode.unscattered_near() + mode.unscattered_far();
      };
      const double expected = unscattered(ours);
      const double noise = std::sqrt(expected * (1.0 - expected) / photons);
      EXPECT_NEAR(walk.unscattered, expected, 3.0 * noise) << eta << ' ' << paths;
      EXPECT_GT(std::abs(walk.unscattered - unscattered(whole)), 3.0 * noise);
      const auto record = [&](const char* what, double monte_carlo, double now, double before) {
        RecordProperty(
            "eta_" + std::to_string(eta).substr(0, 3) + "_paths_" + std::to_string(paths) + "_" +
                what,
            std::to_string(monte_carlo) + " " + std::to_string(now) + " " + std::to_string(before));
      };
      record("unscattered", walk.unscattered, expected, unscattered(whole));
      record("far", walk.transmitted, ours.flux_out_far(), whole.flux_out_far());
      record("lit", walk.reflected, ours.flux_out_near(), whole.flux_out_near());
    }
  }
}

// Thin blocks, where most of the beam reaches the far face: first collisions and what leaves
// without one are exact, whatever diffusion makes of the rest. Normal and oblique beams, open
// sides.
TEST_F(MonteCarloReferee, BeamsInThinBlocksLeaveAsTransportHasIt) {
  constexpr std::uint64_t photons = 400'000;
  constexpr double absorption = 0.4, scattering = 0.6;
  for (const double eta : {1.3, 1.5, 2.4}) {
    for (const double slant : {0.0, 0.4, 1.1}) {
      ForwardProblem problem;
      problem.setup.shape = {9, 7, 5, 0.25};
      problem.setup.eta = eta;
      problem.medium = testing::homogeneous(problem.setup.shape, absorption, scattering);
      problem.irradiance.assign(63, 0.5);
      if (slant > 0.0)
        problem.light.direction = Eigen::Vector3d(std::sin(slant), 0.3 * slant, std::cos(slant));
      const auto [diffusion, transport] = Solved(problem, photons);
      const PowerBalance& d = diffusion.balance[0];
      const PowerBalance& t = transport.balance[0];
      const double share = d.unscattered / d.entering;
      const double noise = std::sqrt(share * (1.0 - share) / static_cast<double>(photons));
      // Sixteen rays stand for the light of an oblique beam's voxel.
      const double rays = slant > 0.0 ? 1e-3 : 1e-6;
      EXPECT_NEAR(t.unscattered / t.entering, share, 3.0 * noise + rays) << eta << ' ' << slant;
      const double out =
          std::accumulate(d.exiting.begin(), d.exiting.end(), d.unscattered + d.absorbed);
      EXPECT_NEAR(out, d.entering, 1e-5 * d.entering);
    }
  }
}

TEST_F(MonteCarloReferee, MarbleOf3mmUnderAPatch) {
  compare(3.0, 2.62, 0.0021, 0.25, 4, 500'000, {0.012, 0.03, 0.006, 0.05});
}

TEST_F(MonteCarloReferee, MarbleOf8mmUnderAPatch) {
  compare(8.0, 2.62, 0.0021, 0.25, 12, 500'000, {0.012, 0.03, 0.006, 0.05});
}

}  // namespace
}  // namespace kappamu::forward
