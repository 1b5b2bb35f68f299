// Against another Monte Carlo program (shared/data/transport-reference), within both standard
// errors: totals, light near the normal, and maps pixel by pixel, in absolute units. Skipped where
// the data or the JSON reader are absent.
#include <gtest/gtest.h>

#if __has_include(<nlohmann/json.hpp>)
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/optics.h"
#include "tests/forward/montecarlo/test_tools.h"
#include "tests/reference_data.h"

namespace kappamu::forward {
namespace {

using nlohmann::json;

class MonteCarloReference : public testing::WithDevice {
 protected:
  void compare(const std::string& name, int voxels_per_mm, std::uint64_t photons) {
    const auto path = reference_data("transport-reference") / (name + ".json");
    std::ifstream in(path);
    if (!in) GTEST_SKIP() << "shared/data/transport-reference is absent";
    const json file = json::parse(in);
    GridSetup setup;
    const std::array<int, 3> size = file["geometry"]["size_mm"];
    setup.shape = {size[0] * voxels_per_mm, size[1] * voxels_per_mm, size[2] * voxels_per_mm,
                   1.0 / voxels_per_mm};
    setup.eta = file["eta"];
    const GridShape& s = setup.shape;
    Medium medium{Volume<double>(s), Volume<double>(s)};
    std::vector<double> light(static_cast<std::size_t>(s.nx) * s.ny, 0.0);
    const std::array<double, 4> patch = file["illumination"]["patch_x0_x1_y0_y1_mm"];
    for (int z = 0; z < s.nz; ++z) {
      for (int y = 0; y < s.ny; ++y) {
        for (int x = 0; x < s.nx; ++x) {
          const std::array<double, 3> p{(x + 0.5) * s.voxel_mm, (y + 0.5) * s.voxel_mm,
                                        (z + 0.5) * s.voxel_mm};
          const double absorption = coefficient(file, "sigma_a", p);
          medium.mu(x, y, z) = absorption;
          medium.kappa(x, y, z) =
              1.0 / (3.0 * (absorption + coefficient(file, "sigma_s_prime", p)));
          const bool lit = p[0] > patch[0] && p[0] < patch[1] && p[1] > patch[2] && p[1] < patch[3];
          if (lit && z == 0) {
            light[static_cast<std::size_t>(y) * s.nx + x] =
                file["illumination"]["irradiance_before_fresnel"];
          }
        }
      }
    }
    Progress silent;
    TraceOptions options;
    options.photons = photons;
    const PhotonTally tally = trace_photons(context(), setup, medium, light, 1, options, silent);
    totals(file, setup, tally);
    map(file, "front", Face::z_minus, setup, tally);
    map(file, "back", Face::z_plus, setup, tally);
  }

 private:
  static double coefficient(const json& file, const char* name, const std::array<double, 3>& p) {
    const json& c = file["coefficients"][name];
    if (c.is_number()) return c;
    const double h = file["coefficients"]["voxel_mm"];
    return c[static_cast<std::size_t>(p[2] / h)][static_cast<std::size_t>(p[1] / h)]
            [static_cast<std::size_t>(p[0] / h)];
  }

  static void totals(const json& file, const GridSetup& setup, const PhotonTally& tally) {
    const json& theirs = file["truth"]["mc"]["totals"];
    const json& theirs_error = file["truth"]["mc"]["totals_se"];
    const double entering = boundary_constants(setup.eta).normal_transmittance;
    EXPECT_NEAR(1.0 - entering, theirs["specular"], 1e-9);
    std::array<Score, 6> faces;
    for (std::size_t f = 0; f < 6; ++f) {
      const std::size_t first = first_pixel(setup.shape, all_faces[f]);
      for (std::size_t k = 0; k < face_shape(setup.shape, all_faces[f]).cells(); ++k) {
        faces[f] += tally.exits[first + k];
      }
    }
    Score side;
    for (std::size_t f = 0; f < 4; ++f) side += faces[f];
    const auto expect = [&](const char* name, const Score& score) {
      const double ours = entering * score.mean(tally.photons);
      const double ours_error = entering * score.standard_error(tally.photons);
      EXPECT_NEAR(ours, theirs[name], 3.0 * std::hypot(ours_error, theirs_error[name])) << name;
    };
    expect("front", faces[4]);
    expect("back", faces[5]);
    expect("side", side);
    expect("front_cone", tally.totals[0].cone[4]);
    expect("back_cone", tally.totals[0].cone[5]);

    // A photon loses at most its all: the mean absorbed part bounds the variance of one.
    const double n = static_cast<double>(tally.photons);
    const auto expect_total = [&](const char* name, double weight, double other) {
      const double ours = entering * weight / Score::full_weight / n;
      const double error = entering * std::sqrt(ours / n);
      EXPECT_NEAR(ours, other, 3.0 * std::hypot(error, theirs_error[name])) << name;
    };
    expect_total("absorbed", static_cast<double>(tally.totals[0].absorbed), theirs["absorbed"]);
    expect_total(
        "unscattered_back", static_cast<double>(tally.totals[0].unscattered),
        theirs["unscattered_back"].get<double>() + theirs["unscattered_front"].get<double>());
  }

  static void map(const json& file, const std::string& side, Face face, const GridSetup& setup,
                  const PhotonTally& tally) {
    constexpr double fewest_photons = 60.0;
    const GridShape& s = setup.shape;
    const double entering = boundary_constants(setup.eta).normal_transmittance;
    const double per_area = entering / (s.voxel_mm * s.voxel_mm);
    const json& theirs = file["truth"]["mc"][side];
    const json& theirs_error = file["truth"]["mc"][side + "_se"];
    // Their pixels may be finer than our voxels.
    const std::size_t n = theirs.size() / static_cast<std::size_t>(s.ny);
    ASSERT_EQ(theirs.size(), n * static_cast<std::size_t>(s.ny));
    const auto area = static_cast<double>(n * n);
    testing::ChiSquare chi;
    for (std::size_t j = 0; j < static_cast<std::size_t>(s.ny); ++j) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(s.nx); ++i) {
        double expected = 0.0, variance = 0.0;
        for (std::size_t k = 0; k < n * n; ++k) {
          const std::size_t row = j * n + k / n, column = i * n + k % n;
          expected += theirs[row][column].get<double>() / area;
          variance += std::pow(theirs_error[row][column].get<double>() / area, 2);
        }
        if (expected < fewest_photons * per_area / static_cast<double>(tally.photons)) continue;
        const Score& score = tally.exits[first_pixel(s, face) + j * s.nx + i];
        chi.add(per_area * score.mean(tally.photons) - expected,
                std::hypot(per_area * score.standard_error(tally.photons), std::sqrt(variance)));
      }
    }
    EXPECT_GT(chi.count, 50) << side;
    EXPECT_TRUE(chi.holds(fewest_photons)) << side;
  }
};

TEST_F(MonteCarloReference, MarbleSlab) {
  compare("h1_marble_3mm", 2, 500'000);
}
TEST_F(MonteCarloReference, Inclusions) {
  compare("c6_inclusions", 1, 400'000);
}

}  // namespace
}  // namespace kappamu::forward
#endif
