// EXR files that are written row by row without compression: OpenEXR reads from them what we do.
#include <OpenImageIO/half.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>

#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/image/plain_exr.h"
#include "tests/io/support.h"

namespace kappamu::io {
namespace {

using testing::HasSubstr;

using Values = std::map<std::string, std::vector<float>>;

class OwnExr : public FolderTest {
 protected:
  /// A part of a picture of 40 x 30 pixels; the flags have 16 bits.
  std::filesystem::path write() {
    ExrHeader header{{8, 4, 24, 17}, 40, 30, {"R", "variance.R", "flags.R", "G", "B"}, {}};
    header.halves = {"flags.R"};
    header.attributes["notes"] = "one\ntwo";
    const auto fill = [&](int y, std::size_t c, float* values) {
      for (int x = 0; x < 24; ++x) {
        const float value = static_cast<float>(y * 24 + x) + 1000.0F * static_cast<float>(c);
        values[x] = c == 2 ? static_cast<float>(x % 8) : value * 1.1F;
      }
    };
    const auto file = folder_ / "a.exr";
    write_plain_exr(file, header, fill);
    return file;
  }
  static Values values_of(const std::filesystem::path& file, int step = 1) {
    Values values;
    const auto open = [&](const ExrHeader& header) -> TakeExrRows {
      EXPECT_EQ(header.data, (Region{8, 4, 24, 17}));
      EXPECT_EQ(header.width, 40);
      EXPECT_EQ(header.attributes.at("notes"), "one\ntwo");
      return [&values, names = header.channels](int, int rows, const float* from) {
        for (int k = 0; k < rows * 24; ++k)
          for (const std::string& name : names) values[name].push_back(*from++);
      };
    };
    read_exr_rows(file, open, {}, [&](const ExrHeader&) { return step; });
    return values;
  }
};

TEST_F(OwnExr, IsReadByOpenExrAlike) {
  const auto file = write();
  ASSERT_TRUE(PlainExrFile::open(file));
  const Values own = values_of(file);
  EXPECT_EQ(own.at("flags.R")[15], 7.0F);
  EXPECT_EQ(own.at("G").back(), (17.0F * 24.0F - 1.0F + 3000.0F) * 1.1F);
  const Image<float> colours = read_float_image(file);  // the display window, by OpenEXR
  EXPECT_EQ(colours.width(), 40);
  EXPECT_EQ(colours(8 + 23, 4 + 16, 1), own.at("G").back());
  // A byte more, and it is no longer laid out as ours are: OpenEXR reads it.
  std::ofstream(file, std::ios::binary | std::ios::app) << '\0';
  ASSERT_FALSE(PlainExrFile::open(file));
  EXPECT_EQ(values_of(file), own);
  const Values fifth = values_of(file, 5);
  write();
  EXPECT_EQ(values_of(file, 5), fifth);
  EXPECT_EQ(fifth.at("G").size(), 4U * 24U);
  EXPECT_EQ(fifth.at("G").back(), own.at("G")[15 * 24 + 23]);
}

TEST_F(OwnExr, DamageIsRefused) {
  const auto file = write();
  const auto size = std::filesystem::file_size(file);
  for (const std::uintmax_t left : {size - 1, size / 2, std::uintmax_t{200}}) {
    write();
    std::filesystem::resize_file(file, left);
    EXPECT_THAT(sentence_of([&] { values_of(file); }), HasSubstr("a.exr: "));
  }
  write();
  std::fstream out(file, std::ios::binary | std::ios::in | std::ios::out);
  out.seekp(static_cast<std::streamoff>(size - (8 + 24 * 18)));  // the last row's own number
  out << '\x7F';
  out.close();
  EXPECT_THAT(sentence_of([&] { values_of(file); }), HasSubstr("truncated or damaged EXR file"));
}

TEST_F(OwnExr, EveryNumberOf16BitsIsKeptAndOthersAreRounded) {
  constexpr int side = 256;
  const auto file = folder_ / "halves.exr";
  const ExrHeader header{{0, 0, side, side}, side, side, {"Y"}, {}, {"Y"}};
  for (const float factor : {1.0F, 1.0F + 0x1p-12F, 1.0F - 0x1p-13F}) {
    const auto value = [&](int x, int y) {
      half number;
      number.setBits(static_cast<std::uint16_t>(side * y + x));
      return factor * number;
    };
    write_plain_exr(file, header, [&](int y, std::size_t, float* values) {
      for (int x = 0; x < side; ++x) values[x] = value(x, y);
    });
    std::optional<PlainExrFile> exr = PlainExrFile::open(file);
    ASSERT_TRUE(exr);
    std::array<float, side> row{};
    for (int y = 0; y < side; ++y) {
      ASSERT_TRUE(exr->read(y, row.data()));
      for (int x = 0; x < side; ++x) {
        const float expected = half(value(x, y));  // OpenEXR's rounding
        if (std::isnan(expected)) {
          EXPECT_TRUE(std::isnan(row[x]));
        } else {
          EXPECT_EQ(row[x], expected) << x << " " << y;
          EXPECT_EQ(std::signbit(row[x]), std::signbit(expected));
        }
      }
    }
  }
}

}  // namespace
}  // namespace kappamu::io
