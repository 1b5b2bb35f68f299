// Frames are written as PNG by strips, compressed by ISA-L: what libpng and zlib read of
// them is what was written.
#include "io/image/png_writer.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/image.h"
#include "io/image/image_file.h"
#include "tests/own_folder.h"

namespace kappamu::io {
namespace {

template <class Code>
void expect_read_back(const OwnFolder& folder, int width, int height, int channels) {
  Image<Code> image(width, height, channels);
  std::mt19937 random(3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < channels; ++c) {
        image(x, y, c) =
            static_cast<Code>(x < width / 2 ? 0 : (random() % 50 + 300 * static_cast<unsigned>(x)));
      }
    }
  }
  write_image(folder / "a.png", image);
  const Image<std::uint16_t> read = read_code_image(folder / "a.png");
  ASSERT_TRUE(read.same_shape(image));
  for (std::size_t i = 0; i < read.size(); ++i) ASSERT_EQ(read.values()[i], image.values()[i]) << i;
}

// One pixel; few rows a strip; several strips, the last one shorter.
TEST(PngWriter, FramesOfAwkwardSizesAreReadBack) {
  const OwnFolder folder;
  for (const int channels : {1, 3}) {
    expect_read_back<std::uint8_t>(folder, 1, 1, channels);
    expect_read_back<std::uint16_t>(folder, 1, 1, channels);
    expect_read_back<std::uint8_t>(folder, 37, 5003, channels);
    expect_read_back<std::uint16_t>(folder, 1013, 601, channels);
    expect_read_back<std::uint16_t>(folder, 60001, 7, channels);
  }
}

// Noise, runs and flat parts in one: no larger than libpng makes it with zlib's defaults.
TEST(PngWriter, NoiseIsAsSmallAsZlibMakesIt) {
  Image<std::uint16_t> image(640, 480, 1);
  std::mt19937 random(2);
  std::normal_distribution<double> noise(20000.0, 60.0);
  for (int y = 0; y < 480; ++y) {
    for (int x = 160; x < 640; ++x) image(x, y, 0) = static_cast<std::uint16_t>(noise(random));
  }
  const PngPixels pixels{image.values().data(), 640, 480, 1, 16};
  EXPECT_LE(write_png(pixels, PngEffort::fast).size(),
            1.02 * static_cast<double>(write_png(pixels, PngEffort::small).size()));
}

TEST(PngWriter, EqualFramesHaveEqualBytes) {
  const Image<std::uint16_t> image(801, 997, 3, 1234);
  const PngPixels pixels{image.values().data(), 801, 997, 3, 16};
  EXPECT_EQ(write_png(pixels, PngEffort::fast), write_png(pixels, PngEffort::fast));
}

}  // namespace
}  // namespace kappamu::io
