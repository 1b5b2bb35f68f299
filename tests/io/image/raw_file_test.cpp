// Camera RAW: a real DNG against a plain unpack of its strip, written here from the DNG
// specification and the file's own tags (SOURCE.md beside it) without LibRaw.
#include "io/image/raw_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "io/read_file.h"
#include "tests/io/support.h"
#include "tests/sentence.h"

namespace kappamu::io {
namespace {

constexpr int full_width = 1888;
constexpr int full_height = 1182;
constexpr int top = 26;
constexpr int left = 152;
constexpr int active_width = 1886 - 152;
constexpr int active_height = 1182 - 26;

std::filesystem::path data_folder() {
  return std::filesystem::path(KAPPAMU_SOURCE_DIR) / ".." / "shared" / "data" /
         "raw-dng-colorchart";
}

class RealRaw : public FolderTest {
 protected:
  void SetUp() override {
    file = data_folder() / "colorchart.dng";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "the real RAW is not beside the sources";
  }
  std::filesystem::path file;
};

// 14 bits a code, packed most significant bit first, one strip at offset 1536.
std::vector<std::uint16_t> plain_unpack(const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = read_bytes(file);
  std::vector<std::uint16_t> codes;
  std::size_t at = 1536;
  std::uint32_t bits = 0;
  int held = 0;
  while (codes.size() < static_cast<std::size_t>(full_width) * full_height) {
    while (held < 14) {
      bits = bits << 8U | std::to_integer<std::uint32_t>(bytes.at(at++));
      held += 8;
    }
    held -= 14;
    codes.push_back(static_cast<std::uint16_t>(bits >> static_cast<unsigned>(held) & 0x3FFFU));
  }
  return codes;
}

TEST_F(RealRaw, GivesTheSensorsOwnCodes) {
  const RawImage raw = read_raw(file);
  ASSERT_EQ(raw.codes.width(), active_width);
  ASSERT_EQ(raw.codes.height(), active_height);
  const std::vector<std::uint16_t> plain = plain_unpack(file);
  // What LibRaw's own unprocessed_raw gave (SOURCE.md).
  EXPECT_EQ(*std::min_element(plain.begin(), plain.end()), 1702);
  EXPECT_EQ(*std::max_element(plain.begin(), plain.end()), 12128);
  long differing = 0;
  for (int y = 0; y < active_height; ++y) {
    for (int x = 0; x < active_width; ++x) {
      differing += raw.codes(x, y) != plain[static_cast<std::size_t>(y + top) * full_width +
                                            static_cast<std::size_t>(x + left)];
    }
  }
  EXPECT_EQ(differing, 0);
}

TEST_F(RealRaw, TellsColoursBlackAndWhite) {
  const RawImage raw = read_raw(file);
  EXPECT_EQ(raw.layout, (BayerLayout{0, 1, 1, 2}));
  EXPECT_EQ(raw.white, 15000);
  for (const double black : raw.black) EXPECT_EQ(black, 2056.0);
}

TEST_F(RealRaw, PatchMeansAreThoseMeasuredByOthers) {
  const RawImage raw = read_raw(file);
  std::ifstream table(data_folder() / "patch_means.csv");
  std::string line;
  std::getline(table, line);
  int patches = 0;
  while (std::getline(table, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream in(line);
    int patch = 0;
    int x0 = 0;
    int y0 = 0;
    std::array<double, 3> expected{};
    in >> patch >> x0 >> y0 >> expected[0] >> expected[1] >> expected[2];
    std::array<double, 3> sum{};
    std::array<double, 3> count{};
    for (int y = y0 - 15; y < y0 + 15; ++y) {
      for (int x = x0 - 15; x < x0 + 15; ++x) {
        const auto c =
            static_cast<std::size_t>((*raw.layout)[static_cast<std::size_t>(2 * (y % 2) + x % 2)]);
        sum[c] += raw.codes(x, y) - 2048.0;
        count[c] += 1.0;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      // A window that begins a pixel off changes the mean by less than a part in a hundred.
      EXPECT_NEAR(sum[c] / count[c], expected[c], 0.01 * expected[c] + 1.0) << patch << " " << c;
    }
    ++patches;
  }
  EXPECT_EQ(patches, 24);
}

TEST_F(RealRaw, TruncatedOrForeignFilesAreRefusedByName) {
  const std::vector<std::byte> bytes = read_bytes(file);
  for (const double share : {0.0, 0.01, 0.5, 0.999}) {
    const std::filesystem::path cut = folder_ / "cut.dng";
    std::ofstream(cut, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(share * static_cast<double>(bytes.size())));
    EXPECT_THAT(sentence_of([&] { read_raw(cut); }), testing::StartsWith(cut.string() + ": "))
        << share;
  }
  const std::filesystem::path text = folder_ / "text.dng";
  std::ofstream(text) << "this is no photograph, only some text that is named like one\n";
  EXPECT_THAT(sentence_of([&] { read_raw(text); }),
              testing::StartsWith(text.string() + ": not a camera RAW file"));
}

TEST(RawFile, IsKnownByItsEnding) {
  EXPECT_TRUE(is_raw_file("a/IMG_0001.CR2"));
  EXPECT_TRUE(is_raw_file("a.dng"));
  EXPECT_FALSE(is_raw_file("a.png"));
  EXPECT_FALSE(is_raw_file("dng"));
}

}  // namespace
}  // namespace kappamu::io
