// BMP as cameras' programs write it: bottom-up rows of blue, green, red, or a palette of greys.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/image/image_file.h"
#include "tests/io/image/plain_exr.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::HasSubstr;

constexpr unsigned width = 5, height = 3;

/// Code of a pixel's channel, row 0 on top.
unsigned code(unsigned x, unsigned y, unsigned c) {
  return 40 * y + 10 * c + x;
}

/// 8 bits with a palette of greys (of colours where `coloured`), 24 or 32 bits.
std::string bmp(unsigned bits, unsigned compression = 0, bool coloured = false) {
  const unsigned colours = bits == 8 ? 256 : 0, row = (width * bits + 31) / 32 * 4;
  const unsigned begin = 54 + 4 * colours;
  std::string bytes = "BM";
  put_number(bytes, begin + row * height, 4);
  put_number(bytes, 0, 4);
  put_number(bytes, begin, 4);
  put_number(bytes, 40, 4);
  put_number(bytes, width, 4);
  put_number(bytes, height, 4);
  put_number(bytes, 1, 2);
  put_number(bytes, bits, 2);
  put_number(bytes, compression, 4);
  put_number(bytes, row * height, 4);
  put_number(bytes, 2835, 4);
  put_number(bytes, 2835, 4);
  put_number(bytes, colours, 4);
  put_number(bytes, 0, 4);
  for (unsigned i = 0; i < colours; ++i) {
    put_number(bytes, i, 1);
    put_number(bytes, coloured ? 255 - i : i, 1);
    put_number(bytes, i, 1);
    put_number(bytes, 0, 1);
  }
  for (unsigned y = height; y-- > 0;) {
    for (unsigned x = 0; x < width; ++x) {
      if (bits == 8) put_number(bytes, code(x, y, 0), 1);
      for (unsigned c = 3; bits >= 24 && c-- > 0;) put_number(bytes, code(x, y, c), 1);
      if (bits == 32) put_number(bytes, 255, 1);
    }
    bytes.resize(begin + row * (height - y));
  }
  return bytes;
}

class Bmp : public FolderTest {
 protected:
  std::filesystem::path write(const std::string& bytes) {
    write_text_atomically(folder_ / "a.bmp", bytes);
    return folder_ / "a.bmp";
  }
};

TEST_F(Bmp, CodesAreThoseOfThePixels) {
  for (const unsigned bits : {8U, 24U, 32U}) {
    const Image<std::uint16_t> image = read_code_image(write(bmp(bits)));
    ASSERT_EQ(image.width(), int{width}) << bits;
    ASSERT_EQ(image.height(), int{height}) << bits;
    ASSERT_EQ(image.channels(), bits == 8 ? 1 : 3) << bits;
    for (unsigned y = 0; y < height; ++y) {
      for (unsigned x = 0; x < width; ++x) {
        for (int c = 0; c < image.channels(); ++c) {
          ASSERT_EQ(image(static_cast<int>(x), static_cast<int>(y), c),
                    code(x, y, static_cast<unsigned>(c)))
              << bits << " " << x << " " << y;
        }
      }
    }
  }
  EXPECT_EQ(read_code_image(write(bmp(8, 0, true))).channels(), 3) << "a palette of colours";
}

TEST_F(Bmp, TruncatedAndUnusualOnesAreRefused) {
  for (const unsigned bits : {8U, 24U}) {
    expect_truncations_are_refused(write(bmp(bits)),
                                   [](const auto& file) { read_code_image(file); });
  }
  const auto run_lengths = write(bmp(8, 1));
  EXPECT_THAT(sentence_of([&] { read_code_image(run_lengths); }),
              HasSubstr("a.bmp: damaged BMP image, or compressed in an unusual way"));
  std::string large = bmp(24);
  large.replace(18, 4, std::string("\xff\xff\x00\x00", 4));
  const auto claims = write(large);
  EXPECT_THAT(sentence_of([&] { read_code_image(claims); }), HasSubstr("truncated BMP image"));
}

}  // namespace
}  // namespace kappamu::io
