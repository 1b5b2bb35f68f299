// Laws of transport and of statistics: energy to the unit, equal bits however the work is spread,
// equivalent faces, reciprocity, and standard errors that tell the truth.
#include <random>
#include <span>

#include "tests/forward/montecarlo/test_tools.h"

namespace kappamu::forward {
namespace {

using testing::ChiSquare;

/// σa from 0 to 0.6 and σs' from 0.5 to 4.5 per mm, independent in every voxel.
Medium rough_medium(const GridShape& shape, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Medium medium = testing::homogeneous(shape, 0.0, 1.0);
  for (std::size_t i = 0; i < shape.cells(); ++i) {
    const double absorption = 0.6 * uniform(generator);
    const double scattering = 0.5 + 4.0 * uniform(generator);
    medium.mu[i] = absorption;
    medium.kappa[i] = 1.0 / (3.0 * (absorption + scattering));
  }
  return medium;
}

class MonteCarloLaw : public testing::WithDevice {
 protected:
  static PhotonTally trace(const GridSetup& setup, const Medium& medium,
                           std::span<const double> light, int patterns,
                           const TraceOptions& options) {
    Progress silent;
    return trace_photons(context(), setup, medium, light, patterns, options, silent);
  }
  static std::span<const Score> face_of(const PhotonTally& tally, const GridShape& shape, Face face,
                                        std::size_t pattern = 0) {
    return std::span(tally.exits)
        .subspan(pattern * surface_pixels(shape) + first_pixel(shape, face),
                 face_shape(shape, face).cells());
  }
};

TEST_F(MonteCarloLaw, WhatEntersIsWhatLeavesAndWhatIsAbsorbedToTheUnit) {
  for (const Sides sides : {Sides::open, Sides::mirror}) {
    for (const SourceModel source : {SourceModel::first_collision, SourceModel::boundary}) {
      GridSetup setup;
      setup.shape = {5, 4, 3, 0.7};
      setup.sides = sides;
      setup.source = source;
      const std::vector<double> light(3 * 20, 1.0);
      TraceOptions options;
      options.photons = 3001;
      options.anisotropy = 0.7;
      const PhotonTally tally = trace(setup, rough_medium(setup.shape, 1), light, 3, options);
      for (std::size_t m = 0; m < 3; ++m) {
        std::uint64_t sum = tally.totals[m].absorbed + tally.totals[m].unscattered;
        for (const Face face : all_faces) {
          for (const Score& s : face_of(tally, setup.shape, face, m)) sum += s.weight;
        }
        EXPECT_EQ(sum, options.photons << 31);
      }
    }
  }
}

TEST_F(MonteCarloLaw, BitsDoNotDependOnHowTheWorkIsSpread) {
  GridSetup setup;
  setup.shape = {6, 5, 4, 0.5};
  const Medium medium = rough_medium(setup.shape, 2);
  std::vector<double> light(2 * 30, 0.0);
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = 1.0 + static_cast<double>(i % 3);
  TraceOptions options;
  options.photons = 30'011;
  options.seed = 0x123456789ABCDEFULL;
  const auto bits = [&](std::optional<std::size_t> items, std::uint64_t seed) {
    options.items = items;
    options.seed = seed;
    const PhotonTally tally = trace(setup, medium, light, 2, options);
    std::vector<std::uint64_t> words;
    for (const Score& s : tally.exits) words.insert(words.end(), {s.weight, s.square});
    for (const PatternTotals& t : tally.totals) {
      words.insert(words.end(), {t.absorbed, t.unscattered});
      for (const Score& s : t.cone) words.insert(words.end(), {s.weight, s.square});
    }
    return words;
  };
  const auto first = bits(std::nullopt, options.seed);
  EXPECT_EQ(bits(std::nullopt, options.seed), first);
  EXPECT_EQ(bits(1, options.seed), first);
  EXPECT_EQ(bits(1000, options.seed), first);
  EXPECT_NE(bits(std::nullopt, options.seed + 1), first);
  // The high half of the seed counts too.
  EXPECT_NE(bits(std::nullopt, options.seed ^ (1ULL << 40)), first);
}

TEST_F(MonteCarloLaw, DarkPatternsStayDark) {
  GridSetup setup;
  setup.shape = {3, 3, 2, 1.0};
  std::vector<double> light(3 * 9, 0.0);
  light[9 + 4] = 2.0;
  TraceOptions options;
  options.photons = 1000;
  const PhotonTally tally = trace(setup, rough_medium(setup.shape, 3), light, 3, options);
  for (const std::size_t dark : {0u, 2u}) {
    EXPECT_EQ(tally.totals[dark].absorbed, 0u);
    for (const Face face : all_faces) {
      for (const Score& s : face_of(tally, setup.shape, face, dark)) EXPECT_EQ(s.weight, 0u);
    }
  }
  EXPECT_GT(tally.totals[1].absorbed, 0u);
}

TEST_F(MonteCarloLaw, EveryFaceIsLitAlike) {
  // The block is laid down so that its lit face becomes each of the others; what leaves by the lit
  // and the opposite face must not notice. (u, v) of the lit face stay (x, y) of the block.
  const GridShape shape{4, 5, 3, 0.6};
  const Medium medium = rough_medium(shape, 4);
  std::vector<double> light(20);
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = 0.2 + static_cast<double>(i % 4);
  TraceOptions options;
  options.photons = 60'000;
  options.anisotropy = 0.5;
  std::vector<PhotonTally> tallies;
  std::vector<GridShape> shapes;
  for (const Face lit : all_faces) {
    GridSetup setup;
    setup.lit_face = lit;
    setup.shape = axis_of(lit) == 0   ? GridShape{shape.nz, shape.nx, shape.ny, shape.voxel_mm}
                  : axis_of(lit) == 1 ? GridShape{shape.nx, shape.nz, shape.ny, shape.voxel_mm}
                                      : shape;
    Medium laid{Volume<double>(setup.shape), Volume<double>(setup.shape)};
    for (int z = 0; z < shape.nz; ++z) {
      for (int y = 0; y < shape.ny; ++y) {
        for (int x = 0; x < shape.nx; ++x) {
          const std::size_t to = face_cell(setup.shape, lit, x, y, z);
          laid.kappa[to] = medium.kappa(x, y, z);
          laid.mu[to] = medium.mu(x, y, z);
        }
      }
    }
    options.seed = 100 + static_cast<std::uint64_t>(lit);
    tallies.push_back(trace(setup, laid, light, 1, options));
    shapes.push_back(setup.shape);
  }
  const std::uint64_t n = options.photons;
  for (const bool far : {false, true}) {
    ChiSquare chi;
    const auto pixels_of = [&](std::size_t f) {
      const Face face = far ? opposite(all_faces[f]) : all_faces[f];
      return face_of(tallies[f], shapes[f], face);
    };
    for (std::size_t f = 0; f < 6; ++f) {
      if (all_faces[f] == Face::z_minus) continue;
      for (std::size_t k = 0; k < light.size(); ++k) {
        const Score& a = pixels_of(f)[k];
        const Score& b = pixels_of(static_cast<std::size_t>(Face::z_minus))[k];
        chi.add(a.mean(n) - b.mean(n), std::hypot(a.standard_error(n), b.standard_error(n)));
      }
    }
    // 100 comparisons share 20 estimates: count them as 20.
    chi.sum *= 20.0 / chi.count;
    chi.count = 20;
    EXPECT_TRUE(chi.holds(200.0)) << (far ? "far face" : "lit face");
  }
}

TEST_F(MonteCarloLaw, IsReciprocal) {
  // Under matched index: what pixel b of the far face sends out while pixel a of the lit face is
  // lit diffusely equals what a sends out while b is lit.
  GridSetup setup;
  setup.shape = {3, 3, 2, 0.5};
  setup.eta = 1.0;
  setup.source = SourceModel::boundary;
  const Medium medium = rough_medium(setup.shape, 5);
  std::vector<double> light(81, 0.0);
  for (std::size_t m = 0; m < 9; ++m) light[m * 9 + m] = 1.0;
  TraceOptions options;
  options.photons = 40'000;
  options.anisotropy = 0.6;
  const PhotonTally down = trace(setup, medium, light, 9, options);
  setup.lit_face = Face::z_plus;
  options.seed = 2;
  const PhotonTally up = trace(setup, medium, light, 9, options);
  ChiSquare chi;
  const std::uint64_t n = options.photons;
  for (std::size_t a = 0; a < 9; ++a) {
    for (std::size_t b = 0; b < 9; ++b) {
      const Score& there = face_of(down, setup.shape, Face::z_plus, a)[b];
      const Score& back = face_of(up, setup.shape, Face::z_minus, b)[a];
      chi.add(there.mean(n) - back.mean(n),
              std::hypot(there.standard_error(n), back.standard_error(n)));
    }
  }
  EXPECT_TRUE(chi.holds(200.0));
}

TEST_F(MonteCarloLaw, StandardErrorsTellTheSpreadOfRepetitions) {
  // Patterns of equal light are repetitions: each has its own stream.
  constexpr std::size_t repetitions = 240;
  GridSetup setup;
  setup.shape = {3, 3, 2, 0.8};
  const Medium medium = rough_medium(setup.shape, 6);
  const std::vector<double> light(repetitions * 9, 1.0);
  TraceOptions options;
  options.photons = 2000;
  const PhotonTally tally = trace(setup, medium, light, static_cast<int>(repetitions), options);
  const std::uint64_t n = options.photons;
  // One quantity per surface pixel of the z faces, then the whole faces and the cones.
  const auto variance_ratio = [&](const auto& score_of) {
    double mean = 0.0, predicted = 0.0, sampled = 0.0;
    for (std::size_t m = 0; m < repetitions; ++m) mean += score_of(m).mean(n) / repetitions;
    for (std::size_t m = 0; m < repetitions; ++m) {
      predicted += std::pow(score_of(m).standard_error(n), 2) / repetitions;
      sampled += std::pow(score_of(m).mean(n) - mean, 2) / (repetitions - 1);
    }
    return sampled / predicted;
  };
  // A sampled variance of 240 is itself known to √(2/239).
  const double spread = std::sqrt(2.0 / (repetitions - 1));
  double sum = 0.0;
  for (const Face face : {Face::z_minus, Face::z_plus}) {
    for (std::size_t k = 0; k < 9; ++k) {
      sum += variance_ratio([&](std::size_t m) { return face_of(tally, setup.shape, face, m)[k]; });
    }
    const double whole = variance_ratio([&](std::size_t m) {
      Score score;
      for (const Score& s : face_of(tally, setup.shape, face, m)) score += s;
      return score;
    });
    EXPECT_NEAR(whole, 1.0, 3.0 * spread);
    const double cone = variance_ratio(
        [&](std::size_t m) { return tally.totals[m].cone[static_cast<std::size_t>(face)]; });
    EXPECT_NEAR(cone, 1.0, 3.0 * spread);
  }
  EXPECT_NEAR(sum / 18.0, 1.0, 3.0 * spread / std::sqrt(18.0));
}

}  // namespace
}  // namespace kappamu::forward
