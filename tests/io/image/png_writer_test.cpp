// Frames are written as PNG by strips, compressed by our own Huffman codes: what libpng and zlib
// read of them is what was written.
#include "io/image/png_writer.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <vector>

#include "core/image.h"
#include "io/image/deflate_runs.h"
#include "io/image/image_file.h"
#include "tests/own_folder.h"

namespace kappamu::io {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes inflated(Bytes stream, std::size_t size) {
  stream.insert(stream.end(), end_of_deflate, end_of_deflate + 2);
  Bytes bytes(size + 1);
  z_stream zlib{};
  inflateInit2(&zlib, -15);  // blocks alone
  zlib.next_in = stream.data();
  zlib.avail_in = static_cast<uInt>(stream.size());
  zlib.next_out = bytes.data();
  zlib.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&zlib, Z_FINISH), Z_STREAM_END);
  EXPECT_EQ(zlib.avail_in, 0U);
  bytes.resize(zlib.total_out);
  inflateEnd(&zlib);
  return bytes;
}

void expect_kept(const Bytes& bytes) {
  Bytes stream;
  deflate_runs(bytes, stream);
  EXPECT_EQ(inflated(stream, bytes.size()), bytes) << bytes.size() << " bytes";
}

TEST(DeflateRuns, ZlibInflatesWhatWasThere) {
  expect_kept({});
  expect_kept({7});
  for (const std::size_t run : {2U, 3U, 4U, 258U, 259U, 260U, 65536U, 65537U, 1000003U}) {
    expect_kept(Bytes(run, 5));
  }
  // Weights as Fibonacci's numbers make the deepest tree, deeper than the 15 bits of a code.
  Bytes deep;
  for (std::uint32_t symbol = 0, one = 1, other = 1; deep.size() < 60000; ++symbol) {
    deep.insert(deep.end(), one, static_cast<std::uint8_t>(symbol));
    std::swap(one, other);
    other += one;
  }
  std::mt19937 random(1);
  std::shuffle(deep.begin(), deep.end(), random);
  expect_kept(deep);
  for (int trial = 0; trial < 100; ++trial) {
    const unsigned values = 1 + random() % 256, longest = 1 + random() % 400;
    Bytes bytes;
    while (bytes.size() < 1000 * static_cast<std::size_t>(trial)) {
      const std::size_t run = random() % 3 == 0 ? 1 + random() % longest : 1;
      bytes.insert(bytes.end(), run, static_cast<std::uint8_t>(random() % values));
    }
    expect_kept(bytes);
  }
}

// Of noise it takes no more room than zlib's own runs.
TEST(DeflateRuns, NoiseIsAsSmallAsZlibMakesIt) {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(128.0, 9.0);
  Bytes bytes(300000);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(noise(random));
  Bytes ours, zlibs(2 * bytes.size());
  deflate_runs(bytes, ours);
  z_stream zlib{};
  deflateInit2(&zlib, 1, Z_DEFLATED, -15, 9, Z_RLE);
  zlib.next_in = bytes.data();
  zlib.avail_in = static_cast<uInt>(bytes.size());
  zlib.next_out = zlibs.data();
  zlib.avail_out = static_cast<uInt>(zlibs.size());
  EXPECT_EQ(deflate(&zlib, Z_FINISH), Z_STREAM_END);
  EXPECT_LE(ours.size(), zlib.total_out + zlib.total_out / 200);
  deflateEnd(&zlib);
}

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

TEST(PngWriter, EqualFramesHaveEqualBytes) {
  const Image<std::uint16_t> image(801, 997, 3, 1234);
  const PngPixels pixels{image.values().data(), 801, 997, 3, 16};
  EXPECT_EQ(write_png(pixels, PngEffort::fast), write_png(pixels, PngEffort::fast));
}

}  // namespace
}  // namespace kappamu::io
