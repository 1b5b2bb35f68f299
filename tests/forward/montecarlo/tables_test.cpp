// What photons look up, and the random numbers they draw.
#include "forward/montecarlo/photon_tables.h"

#include <random>

#include "core/error.h"
#include "tests/forward/montecarlo/test_tools.h"
#include "tests/sentence.h"

namespace kappamu::forward {
namespace {

class PhotonRandom : public testing::WithDevice {};

TEST_F(PhotonRandom, GivesThePublishedBlocks) {
  // kat_vectors of Random123 (Salmon et al. 2011), philox4x32 with 10 rounds.
  const std::vector<PhiloxBlock> zero{{0, 0, 0, 0}};
  EXPECT_EQ(philox_blocks(context(), {0, 0}, zero).front(),
            (PhiloxBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  const std::vector<PhiloxBlock> ones{{~0u, ~0u, ~0u, ~0u}, {~0u, ~0u, ~0u, ~0u}};
  for (const PhiloxBlock& block : philox_blocks(context(), {~0u, ~0u}, ones)) {
    EXPECT_EQ(block, (PhiloxBlock{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  }
}

TEST(PhotonRandomOfTheHost, GivesThePublishedBlocks) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}),
            (PhiloxBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (PhiloxBlock{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(AliasTable, HoldsEveryWeight) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (const std::size_t n : {1u, 2u, 7u, 1000u}) {
    std::vector<double> weights(n);
    for (std::size_t i = 0; i < n; ++i) {
      weights[i] = i % 3 == 1 ? 0.0 : std::pow(10.0, -4.0 * uniform(generator));
    }
    double sum = 0.0;
    for (const double w : weights) sum += w;
    const std::vector<AliasEntry> table = alias_table(weights);
    std::vector<double> chance(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      const double keep = table[i].other == i ? 1.0 : table[i].keep / 0x1p32;
      chance[i] += keep / static_cast<double>(n);
      chance[table[i].other] += (1.0 - keep) / static_cast<double>(n);
    }
    // Each entry is right to 2^-32 of the mean; a bright pixel gathers the rounding of many.
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(chance[i], weights[i] / sum, 0x1p-31) << i;
  }
}

TEST(AliasTable, NeverEntersDarkPixels) {
  const std::vector<double> weights{0.0, 3.0, 0.0, 0.0, 1.0, 0.0};
  const std::vector<AliasEntry> table = alias_table(weights);
  for (const std::size_t dark : {0u, 2u, 3u, 5u}) {
    EXPECT_EQ(table[dark].keep, 0u);
    EXPECT_GT(weights[table[dark].other], 0.0);
  }
  for (const AliasEntry& entry : table) EXPECT_GT(weights[entry.other], 0.0);
}

TEST(CollisionTable, HoldsExtinctionAndAlbedo) {
  const GridShape shape{2, 1, 1, 1.0};
  Medium medium = testing::homogeneous(shape, 0.5, 1.5);
  medium.kappa[1] = 1.0 / (3.0 * 0.25);  // pure absorber
  medium.mu[1] = 0.25;
  const CollisionTable table = collision_table(medium, 0.5);
  EXPECT_DOUBLE_EQ(table.majorant, 0.5 + 1.5 / (1.0 - 0.5));
  EXPECT_EQ(table.voxels[0].real, 0xFFFFFFFF);
  EXPECT_NEAR(table.voxels[0].absorbed / 0x1p32, 0.5 / 3.5, 1e-9);
  EXPECT_NEAR(table.voxels[1].real / 0x1p32, 0.25 / 3.5, 1e-9);
  EXPECT_EQ(table.voxels[1].absorbed, 0xFFFFFFFF);
}

TEST(CollisionTable, RefusesWhatIsNoMedium) {
  const GridShape shape{2, 2, 2, 1.0};
  Medium medium = testing::homogeneous(shape, 0.5, 1.5);
  medium.mu(1, 0, 1) = 2.1;
  const std::string sentence = sentence_of([&] { collision_table(medium, 0.0); });
  EXPECT_NE(sentence.find("(1, 0, 1)"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("3 kappa mu > 1"), std::string::npos) << sentence;
  medium.mu(1, 0, 1) = 0.5;
  for (const double g : {1.0, -1.0, 1.5, std::nan("")}) {
    EXPECT_THROW(collision_table(medium, g), InputError) << g;
  }
}

// A photon would scatter a million times, and a million photons would take hours.
TEST(CollisionTable, LightThatScattersForEverIsRefused) {
  const GridShape shape{4, 4, 4, 0.5};
  Medium medium{Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)};
  collision_table(medium, 0.0);
  medium.kappa[5] = 1e-7;
  EXPECT_NE(sentence_of([&] { collision_table(medium, 0.0); }).find("choose a model of diffusion"),
            std::string::npos);
}

}  // namespace
}  // namespace kappamu::forward
